#include "render/scene/texture/node_parameters.h"

#include <cmath>

#include "absl/strings/str_cat.h"

namespace tessera::render {

namespace {

absl::Status set_texture_space(const v1::Matrix& texture_from_world, const RenderSpace& space,
                               TextureNode& node) {
  const auto from_world = Transform::from_proto(texture_from_world);
  if (!from_world.ok()) return from_world.status();
  Transform world_from_render;
  if (!space.from_world.invert(world_from_render)) return absl::InternalError("render space is singular");
  node.texture_from_render = (*from_world * world_from_render).to_affine();
  return absl::OkStatus();
}

}  // namespace

TextureNode constant_node(const spectra::Rgb& value) {
  TextureNode node;
  node.value[0] = value.r, node.value[1] = value.g, node.value[2] = value.b;
  return node;
}

absl::Status set_mapping(const v1::UvMapping& mapping, const RenderSpace& space, TextureNode& node) {
  node.scale_u = mapping.has_scale_u() ? mapping.scale_u() : 1;
  node.scale_v = mapping.has_scale_v() ? mapping.scale_v() : 1;
  node.offset_u = mapping.offset_u();
  node.offset_v = mapping.offset_v();
  node.u_from_v = mapping.u_from_v();
  node.v_from_u = mapping.v_from_u();
  switch (mapping.source()) {
    case v1::UvMapping::SPHERICAL:
      node.source = UvSource::kSpherical;
      break;
    case v1::UvMapping::CYLINDRICAL:
      node.source = UvSource::kCylindrical;
      break;
    case v1::UvMapping::PLANAR:
      node.source = UvSource::kPlanar;
      break;
    default:
      node.source = UvSource::kSurface;
      break;
  }
  node.plain_uv = node.source == UvSource::kSurface && node.u_from_v == 0 && node.v_from_u == 0;
  return set_texture_space(mapping.texture_from_world(), space, node);
}

absl::Status set_noise(const v1::NoiseTexture& noise, const RenderSpace& space, TextureNode& node) {
  constexpr std::uint32_t kMostOctaves = 64;
  node.kind = TextureKind::kNoise;
  switch (noise.kind()) {
    case v1::NoiseTexture::WRINKLED:
      node.noise = NoiseKind::kWrinkled;
      break;
    case v1::NoiseTexture::WINDY:
      node.noise = NoiseKind::kWindy;
      break;
    case v1::NoiseTexture::MARBLE:
      node.noise = NoiseKind::kMarble;
      break;
    default:
      node.noise = NoiseKind::kFbm;
      break;
  }
  if (noise.octaves() > kMostOctaves) {
    return absl::InvalidArgumentError(
        absl::StrCat("it has ", noise.octaves(), " octaves, more than ", kMostOctaves));
  }
  if (noise.has_octaves()) node.octaves = static_cast<std::int32_t>(noise.octaves());
  if (noise.has_roughness()) node.roughness = noise.roughness();
  if (noise.has_scale()) node.scale = noise.scale();
  if (noise.has_variation()) node.variation = noise.variation();
  for (const float x : {node.roughness, node.scale, node.variation}) {
    if (!std::isfinite(x)) return absl::InvalidArgumentError("a number of its noise is not finite");
  }
  return set_texture_space(noise.texture_from_world(), space, node);
}

absl::Status set_direction(const v1::Point3& world, const RenderSpace& space, TextureNode& node) {
  const Imath::V3d d = space.from_world.apply_vector({world.x(), world.y(), world.z()});
  const double l = d.length();
  if (!(l > 0) || !std::isfinite(l)) return absl::InvalidArgumentError("its direction is zero or not finite");
  const double components[] = {d.x / l, d.y / l, d.z / l};
  for (int i = 0; i < 3; ++i) node.direction[i] = static_cast<float>(components[i]);
  return absl::OkStatus();
}

void fold(const TextureTable& table, TextureNode& node) {
  const auto input = [&](int i) -> const TextureNode& {
    return table.nodes[static_cast<std::size_t>(node.inputs[i])];
  };
  const int count = node.kind == TextureKind::kMix ? 3 : node.kind == TextureKind::kScale ? 2 : 0;
  for (int i = 0; i < count; ++i) {
    if (input(i).kind != TextureKind::kConstant) return;
  }
  if (count == 0) return;
  TextureNode folded;
  for (int c = 0; c < 3; ++c) {
    if (node.kind == TextureKind::kScale) {
      folded.value[c] = input(0).value[c] * input(1).value[c];
    } else {
      const float* amount = input(2).value;
      const float t = (amount[0] + amount[1] + amount[2]) / 3;
      folded.value[c] = (1 - t) * input(0).value[c] + t * input(1).value[c];
    }
  }
  node = folded;
}

}  // namespace tessera::render
