#include "render/scene/spectral/unreached_color.h"

#include <algorithm>
#include <cstddef>

#include "absl/strings/str_format.h"
#include "spectra/color/lab.h"
#include "spectra/color/rgb_space.h"
#include "spectra/upsampling/upsample.h"

namespace tessera::render {
namespace {

using spectra::Rgb;

spectra::Lab lab_of_rec709(const Rgb& rgb) {
  const spectra::Matrix3 to_xyz = spectra::xyz_from_rgb(spectra::kRec709);
  return spectra::lab_of(spectra::times(to_xyz, {rgb.r, rgb.g, rgb.b}), spectra::times(to_xyz, {1, 1, 1}));
}

float least_component(const Rgb& rgb) { return std::min({rgb.r, rgb.g, rgb.b}); }

/// Looks at every level of an image: the first holds all texels, where it is there.
void look_at(const BigArray<float>& texels, Rgb& least) {
  for (std::size_t i = 0; i + 3 < texels.size(); i += 4) {
    const Rgb texel = {texels[i], texels[i + 1], texels[i + 2]};
    if (least_component(texel) < least_component(least)) least = texel;
  }
}

void look_at(const TextureTable& textures, std::int32_t number, Rgb& least) {
  const TextureNode& node = textures.nodes[static_cast<std::size_t>(number)];
  if (node.kind == TextureKind::kConstant) {
    const Rgb color = {node.value[0], node.value[1], node.value[2]};
    if (least_component(color) < least_component(least)) least = color;
  }
  if (node.image && !node.invert && node.channel < 0) {
    look_at(node.image->texels32, least);
    look_at(node.image->pyramid.texels32, least);
  }
  for (const std::int32_t input : node.inputs) {
    if (input >= 0) look_at(textures, input, least);
  }
}

}  // namespace

bool UnreachedColor::is_told() const { return error > spectra::kMostUpsamplingError; }

std::string UnreachedColor::to_string() const {
  return absl::StrFormat(
      "no spectrum has its colour (%.3g, %.3g, %.3g) in linear Rec.709: the nearest is %.1f off in CIEDE2000",
      color.r, color.g, color.b, error);
}

UnreachedColor worst_texel(const TextureTable& textures, std::int32_t node) {
  Rgb least = {0, 0, 0};
  look_at(textures, node, least);
  if (least_component(least) >= 0) return {};
  const Rgb clamped = {std::max(least.r, 0.0f), std::max(least.g, 0.0f), std::max(least.b, 0.0f)};
  return {least, spectra::delta_e2000(lab_of_rec709(least), lab_of_rec709(clamped))};
}

}  // namespace tessera::render
