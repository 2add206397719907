// Parameters that several kinds of materials have in common.
#include <cmath>

#include "absl/strings/str_cat.h"
#include "render/bsdf/slots.h"
#include "render/build/scene_builder.h"

namespace tessera::render {

namespace {

void put_color(const Rgb& rgb, SpectrumSlot& slot) {
  slot.value[0] = rgb.r, slot.value[1] = rgb.g, slot.value[2] = rgb.b;
}

}  // namespace

absl::Status SceneBuilder::set_spectrum(const v1::SpectrumValue& value, const Rgb& otherwise,
                                        MaterialRecord& record, SpectrumSlot& slot) {
  if (value.has_texture()) {
    auto node = texture_node(value.texture());
    if (!node.ok()) return node.status();
    const TextureNode& texture = arrays_.textures.nodes[static_cast<std::size_t>(*node)];
    if (texture.kind == TextureKind::kConstant) {
      put_color({texture.value[0], texture.value[1], texture.value[2]}, slot);
      return absl::OkStatus();
    }
    slot.texture = *node;
    record.flags |= kHasTextures;
    return absl::OkStatus();
  }
  if (auto s = check_spectrum(value.constant(), "spectrum"); !s.ok()) return s;
  put_color(value.has_constant() ? reflectance(value.constant()) : otherwise, slot);
  return absl::OkStatus();
}

absl::Status SceneBuilder::set_scalar(const v1::FloatValue& value, float otherwise, MaterialRecord& record,
                                      ScalarSlot& slot) {
  if (value.has_texture()) {
    auto node = texture_node(value.texture());
    if (!node.ok()) return node.status();
    const TextureNode& texture = arrays_.textures.nodes[static_cast<std::size_t>(*node)];
    if (texture.kind == TextureKind::kConstant) {
      slot.value = (texture.value[0] + texture.value[1] + texture.value[2]) / 3;
      return absl::OkStatus();
    }
    slot.texture = *node;
    record.flags |= kHasTextures;
    return absl::OkStatus();
  }
  const float constant = value.has_constant() ? value.constant() : otherwise;
  if (!std::isfinite(constant)) return absl::InvalidArgumentError("a parameter is not finite");
  slot.value = constant;
  return absl::OkStatus();
}

absl::Status SceneBuilder::set_tint(const v1::SpectrumValue& value, MaterialRecord& record,
                                    SpectrumSlot& slot) {
  if (auto s = set_spectrum(value, {1, 1, 1}, record, slot); !s.ok()) return s;
  if (slot.texture >= 0 || slot.value[0] != 1 || slot.value[1] != 1 || slot.value[2] != 1)
    record.flags |= kTinted;
  return absl::OkStatus();
}

absl::Status SceneBuilder::set_roughness(const v1::Roughness& roughness, MaterialRecord& record,
                                         ScalarSlot& u, ScalarSlot& v) {
  if (roughness.remap()) record.flags |= kRemapAlpha;
  if (roughness.distribution() == v1::Roughness::BECKMANN) record.flags |= kBeckmann;
  if (roughness.separable_masking()) record.flags |= kSeparableMasking;
  for (const auto& [value, alpha] : {std::pair(&roughness.u(), &u), std::pair(&roughness.v(), &v)}) {
    if (auto s = set_scalar(*value, 0, record, *alpha); !s.ok()) return s;
    if (alpha->texture >= 0) continue;
    if (alpha->value < 0) return absl::InvalidArgumentError("a roughness is below 0");
    if (roughness.remap()) alpha->value = std::sqrt(alpha->value);
    alpha->value = std::fmin(alpha->value, 1.0f);
  }
  if (u.texture != v.texture || (u.texture < 0 && u.value != v.value)) record.flags |= kAnisotropic;
  return absl::OkStatus();
}

absl::Status SceneBuilder::set_eta(const v1::Spectrum& spectrum, float otherwise, MaterialRecord& record) {
  float eta = otherwise;
  if (auto s = check_spectrum(spectrum, "index of refraction"); !s.ok()) return s;
  if (spectrum.has_sampled()) {
    const auto& s = spectrum.sampled();
    eta = dielectric_eta(
        {{s.wavelengths_nm().begin(), s.wavelengths_nm().end()}, {s.values().begin(), s.values().end()}});
  } else if (spectrum.kind_case() != v1::Spectrum::KIND_NOT_SET) {
    eta = emission(spectrum).g;
  }
  record.scalars[slot::kEta].value = eta;
  return check_eta(eta);
}

absl::Status SceneBuilder::check_eta(float eta) {
  constexpr float kLowest = 1e-4f, kHighest = 1e4f;
  if (eta >= kLowest && eta <= kHighest) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("an index of refraction of ", eta, " is not between ", kLowest, " and ", kHighest));
}

void SceneBuilder::set_multiple_scattering(const v1::Roughness& roughness, float eta,
                                           MaterialRecord& record) {
  if (roughness.has_multiple_scattering() && !roughness.multiple_scattering()) return;
  if (record.flags & kAllDelta) return;
  const ScalarSlot &u = record.scalars[slot::kAlphaX], &v = record.scalars[slot::kAlphaY];
  // There is a table for two roughnesses, or for all that are the same along u and v.
  if (u.texture != v.texture) return;
  BalancedFacets facets{.textured = u.texture >= 0,
                        .beckmann = (record.flags & kBeckmann) != 0,
                        .separable_masking = (record.flags & kSeparableMasking) != 0,
                        .eta = eta};
  if (!facets.textured) facets.alpha_x = u.value, facets.alpha_y = v.value;
  const auto [table, added] = balance_tables_.try_emplace(facets, 0);
  if (added) table->second = append_balance_table(facets, arrays_.materials);
  record.coat_table = table->second;
  record.flags |= kBalanced | kUsesEta;
}

ExtendedRecord& SceneBuilder::extend(MaterialRecord& record) {
  record.flags |= kUsesExtended;
  record.extended = static_cast<std::int32_t>(arrays_.materials.extended.size());
  return arrays_.materials.extended.emplace_back();
}

}  // namespace tessera::render
