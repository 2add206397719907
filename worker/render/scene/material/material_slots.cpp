#include "render/scene/material/material_slots.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "render/bsdf/kinds.h"
#include "render/scene/values/spectra.h"
#include "spectra/rgb/scene_rgb.h"
#include "wire/dispersion.h"
#include "wire/scene_numbers.h"

namespace tessera::render {

void put(const spectra::Rgb& rgb, SpectrumSlot& slot) {
  slot.value[0] = rgb.r, slot.value[1] = rgb.g, slot.value[2] = rgb.b;
}

absl::StatusOr<std::optional<spectra::Rgb>> MaterialSlots::look_up(const std::string& texture,
                                                                   std::int32_t& slot) {
  const auto node = exact_ ? inputs_.textures.exact_node(texture) : inputs_.textures.node(texture);
  if (!node.ok()) return node.status();
  const TextureNode& found = inputs_.textures.table().nodes[static_cast<std::size_t>(*node)];
  if (found.kind == TextureKind::kConstant)
    return spectra::Rgb{found.value[0], found.value[1], found.value[2]};
  slot = *node;
  record.flags |= kHasTextures;
  return std::nullopt;
}

absl::Status MaterialSlots::set_spectrum(const v1::SpectrumValue& value, const spectra::Rgb& otherwise,
                                         SpectrumSlot& slot) {
  if (value.has_texture()) {
    const auto texture = look_up(value.texture(), slot.texture);
    if (!texture.ok()) return texture.status();
    if (*texture) put(**texture, slot);
    return absl::OkStatus();
  }
  if (auto s = check_spectrum(value.constant(), "spectrum"); !s.ok()) return s;
  put(value.has_constant() ? reflectance(value.constant()) : otherwise, slot);
  if (inputs_.spectral == nullptr) return absl::OkStatus();
  slot.curve = inputs_.spectral->add_measured(value.constant()).value_or(-1);
  return absl::OkStatus();
}

absl::Status MaterialSlots::set_scalar(const v1::FloatValue& value, float otherwise, ScalarSlot& slot) {
  if (value.has_texture()) {
    const auto texture = look_up(value.texture(), slot.texture);
    if (!texture.ok()) return texture.status();
    if (*texture) slot.value = ((*texture)->r + (*texture)->g + (*texture)->b) / 3;
    return absl::OkStatus();
  }
  const float constant = value.has_constant() ? value.constant() : otherwise;
  if (!std::isfinite(constant)) return absl::InvalidArgumentError("a parameter is not finite");
  slot.value = constant;
  return absl::OkStatus();
}

absl::Status MaterialSlots::set_opacity(const v1::FloatValue& value) {
  exact_ = true;
  const absl::Status set = set_scalar(value, 1, record.opacity);
  exact_ = false;
  record.opacity.value = std::clamp(record.opacity.value, 0.0f, 1.0f);
  if (record.opacity.texture >= 0 || record.opacity.value < 1) record.flags |= kHasOpacity;
  return set;
}

absl::Status MaterialSlots::set_tint(const v1::SpectrumValue& value, SpectrumSlot& slot) {
  if (auto s = set_spectrum(value, {1, 1, 1}, slot); !s.ok()) return s;
  if (slot.texture >= 0 || slot.value[0] != 1 || slot.value[1] != 1 || slot.value[2] != 1)
    set_variants(record, kTinted);
  return absl::OkStatus();
}

absl::Status MaterialSlots::set_roughness(const v1::Roughness& roughness, ScalarSlot& u, ScalarSlot& v) {
  if (roughness.remap()) record.flags |= kRemapAlpha;
  if (roughness.distribution() == v1::Roughness::BECKMANN) set_variants(record, kBeckmann);
  if (roughness.separable_masking()) set_variants(record, kSeparableMasking);
  for (const auto& [value, alpha] : {std::pair(&roughness.u(), &u), std::pair(&roughness.v(), &v)}) {
    if (auto s = set_scalar(*value, 0, *alpha); !s.ok()) return s;
    if (alpha->texture >= 0) continue;
    if (alpha->value < 0) return absl::InvalidArgumentError("a roughness is below 0");
    if (roughness.remap()) alpha->value = std::sqrt(alpha->value);
    alpha->value = std::fmin(alpha->value, 1.0f);
  }
  if (u.texture != v.texture || (u.texture < 0 && u.value != v.value)) record.flags |= kAnisotropic;
  return absl::OkStatus();
}

absl::Status MaterialSlots::set_eta(const v1::Spectrum& spectrum, float otherwise) {
  float eta = otherwise;
  if (auto s = check_spectrum(spectrum, "index of refraction"); !s.ok()) return s;
  if (const auto curve = measured_curve(spectrum); curve && !spectrum.has_in_rgb()) {
    eta = spectra::dielectric_eta(*curve);
  } else if (spectrum.kind_case() != v1::Spectrum::KIND_NOT_SET) {
    eta = emission(spectrum).g;
  }
  record.scalars[slot::kEta].value = eta;
  return wire::check_index(eta);
}

absl::Status MaterialSlots::set_coat_eta(const v1::Spectrum& eta, float otherwise) {
  if (auto s = set_eta(eta, otherwise); !s.ok() || inputs_.spectral == nullptr) return s;
  const std::optional<spectra::Curve> measured = measured_curve(eta);
  if (!measured) return absl::OkStatus();
  const double violet = measured->at(400), red = measured->at(700);
  if (violet != red) {
    warn(absl::StrCat("its coat has the index ", record.scalars[slot::kEta].value,
                      " at all wavelengths, that at 589.3 nm; measured are ", violet, " at 400 nm and ", red,
                      " at 700 nm"));
  }
  return absl::OkStatus();
}

absl::Status MaterialSlots::set_dispersing_eta(const v1::Spectrum& eta, bool has_dispersion,
                                               const v1::Dispersion& dispersion, float otherwise) {
  constexpr double kSodiumNm = 589.3;  // that of spectra::dielectric_eta()
  std::function<double(double)> index;
  if (has_dispersion) {
    if (eta.kind_case() != v1::Spectrum::KIND_NOT_SET)
      return absl::InvalidArgumentError("eta and dispersion exclude each other");
    const auto formula = wire::dispersion_of(dispersion);
    if (!formula.ok()) return formula.status();
    record.scalars[slot::kEta].value = static_cast<float>(formula->eta(kSodiumNm));
    index = [of = *formula](double nm) { return of.eta(nm); };
  } else {
    const std::optional<spectra::Curve> measured = measured_curve(eta);
    if (auto s = set_eta(eta, otherwise); !s.ok() || !measured) return s;
    index = [of = *measured](double nm) { return of.at(nm); };
  }
  set_varying_eta(index);
  return absl::OkStatus();
}

void MaterialSlots::set_varying_eta(const std::function<double(double)>& index) {
  if (inputs_.spectral == nullptr) return;
  const auto curve = inputs_.spectral->add_varying(index);
  if (!curve) return;
  record.flags |= kDisperses;
  record.eta_curve = *curve;
}

void MaterialSlots::set_multiple_scattering(const v1::Roughness& roughness, float eta) {
  if (roughness.has_multiple_scattering() && !roughness.multiple_scattering()) return;
  if (record.flags & kAllDelta) return;
  const ScalarSlot &u = record.scalars[slot::kAlphaX], &v = record.scalars[slot::kAlphaY];
  // There is a table for two roughnesses, or for all that are the same along u and v.
  if (u.texture != v.texture) return;
  BalancedFacets facets{.textured = u.texture >= 0,
                        .beckmann = (record.variants & kBeckmann) != 0,
                        .separable_masking = (record.variants & kSeparableMasking) != 0,
                        .eta = eta};
  if (!facets.textured) facets.alpha_x = u.value, facets.alpha_y = v.value;
  record.coat_table = inputs_.energies.balance(facets);
  record.flags |= kUsesEta;
  set_variants(record, kBalanced);
}

ExtendedRecord& MaterialSlots::extend() {
  record.flags |= kUsesExtended;
  record.extended = static_cast<std::int32_t>(inputs_.table.extended.size());
  return inputs_.table.extended.emplace_back();
}

absl::Status MaterialSlots::set_upper_normal(const v1::ImageTexture& map) {
  const auto node = inputs_.textures.normal_map(map);
  if (!node.ok()) return node.status();
  record.upper_normal_texture = *node;
  return absl::OkStatus();
}

void MaterialSlots::scale_spectra(float factor) {
  for (SpectrumSlot& slot : record.spectra) {
    if (slot.texture >= 0 && factor != 1) slot.texture = inputs_.textures.scaled(slot.texture, factor);
    if (slot.curve >= 0 && factor != 1)
      slot.curve = inputs_.spectral->add_function_of(slot.curve, [&](float v) { return v * factor; });
    for (float& v : slot.value) v *= factor;
  }
}

void MaterialSlots::warn(const std::string& what) {
  inputs_.warnings.push_back(absl::StrCat("material '", name_, "': ", what));
}

}  // namespace tessera::render
