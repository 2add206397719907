#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "render/bsdf/kinds.h"
#include "render/core/constants.h"
#include "render/scene/material/material_kinds.h"
#include "spectra/matter/dispersion.h"
#include "wire/scene_numbers.h"

namespace tessera::render {

namespace {

constexpr float kLeastIndexStep = 1e-3f;  // nothing is refracted where the index does not change

absl::Status set_usual_slots(const v1::GltfMaterial& gltf, ExtendedRecord& extended, MaterialSlots& slots) {
  MaterialRecord& record = slots.record;
  const struct {
    const v1::FloatValue& value;
    float otherwise;
    ScalarSlot& target;
  } scalars[] = {{gltf.roughness(), 1, record.scalars[slot::kRoughness]},
                 {gltf.anisotropy(), 0, record.scalars[slot::kAnisotropic]},
                 {gltf.metallic(), 1, extended.scalars[slot::kMetallic]},
                 {gltf.transmission(), 0, extended.scalars[slot::kTransmission]},
                 {gltf.specular(), 1, extended.scalars[slot::kSpecular]},
                 {gltf.clearcoat(), 0, extended.scalars[slot::kCoat]},
                 {gltf.clearcoat_roughness(), 0, extended.scalars[slot::kCoatRoughness]},
                 {gltf.sheen_roughness(), 0, extended.scalars[slot::kSheenRoughness]},
                 {gltf.diffuse_transmission(), 0, extended.scalars[slot::kBehind]},
                 {gltf.iridescence(), 0, extended.further[slot::kFilm]}};
  for (const auto& [value, otherwise, target] : scalars) {
    if (auto s = slots.set_scalar(value, otherwise, target); !s.ok()) return s;
    target.value = std::clamp(target.value, 0.0f, 1.0f);
  }
  const struct {
    const v1::SpectrumValue& value;
    spectra::Rgb otherwise;
    SpectrumSlot& target;
  } spectra[] = {
      {gltf.base_color(), {1, 1, 1}, record.spectra[slot::kReflectance]},
      {gltf.specular_color(), {1, 1, 1}, record.spectra[slot::kSpecularColor]},
      {gltf.sheen_color(), {0, 0, 0}, extended.spectra[slot::kSheenColor]},
      {gltf.diffuse_transmission_color(), {1, 1, 1}, extended.spectra[slot::kBehindColor]},
      {gltf.anisotropy_direction(), {1, 0.5f, 1}, extended.further_colors[slot::kAnisotropyDirection]}};
  for (const auto& [value, otherwise, target] : spectra) {
    if (auto s = slots.set_spectrum(value, otherwise, target); !s.ok()) return s;
  }
  return absl::OkStatus();
}

absl::Status set_film(const v1::GltfMaterial& gltf, ExtendedRecord& extended, MaterialSlots& slots) {
  constexpr float kUsualIndex = 1.3f, kUsualThickness = 400, kMostIndex = 1e4f, kMostThickness = 1e6f;
  const float index = gltf.has_iridescence_ior() ? gltf.iridescence_ior() : kUsualIndex;
  if (!(index >= 1 && index <= kMostIndex))
    return absl::InvalidArgumentError(
        absl::StrCat("an iridescence_ior of ", index, " is not between 1 and ", kMostIndex));
  ScalarSlot& thickness = extended.further[slot::kFilmThickness];
  if (auto s = slots.set_scalar(gltf.iridescence_thickness(), kUsualThickness, thickness); !s.ok()) return s;
  if (!(thickness.value >= 0))
    return absl::InvalidArgumentError(
        absl::StrCat("an iridescence_thickness of ", thickness.value, " nm is below 0"));
  thickness.value = std::min(thickness.value, kMostThickness);
  extended.further[slot::kFilmEta].value = index;
  if (is_zero(extended.further[slot::kFilm])) return absl::OkStatus();
  slots.record.flags |= kUsesFurther | kPrepared;
  slots.energies().films();
  return absl::OkStatus();
}

/// Half of what the indices of red and blue are apart [KHR_materials_dispersion]: neither comes to where
/// nothing is refracted. Where light has wavelengths, the index is a curve instead.
absl::Status set_dispersion(float dispersion, float eta, ExtendedRecord& extended, MaterialSlots& slots) {
  MaterialRecord& record = slots.record;
  if (!(dispersion >= 0) || !std::isfinite(dispersion))
    return absl::InvalidArgumentError(
        absl::StrCat("a dispersion of ", dispersion, " is below 0 or not finite"));
  if (dispersion == 0 || (record.flags & kHasInside) == 0) return absl::OkStatus();
  if (slots.spectral() != nullptr) {
    constexpr double kAbbeOfOne = 20;
    const spectra::Dispersion formula = spectra::abbe_dispersion(eta, kAbbeOfOne / dispersion);
    slots.set_varying_eta([=](double nm) {
      const double index = formula.eta(nm);
      return eta < 1 ? std::min(index, 1.0 - kLeastIndexStep) : std::max(index, 1.0 + kLeastIndexStep);
    });
    return absl::OkStatus();
  }
  const float step = eta - 1, most = std::max(1 - kLeastIndexStep / std::abs(step), 0.0f);
  extended.further[slot::kSpread].value = step * std::min(0.025f * dispersion, most);
  record.flags |= kUsesFurther;
  return absl::OkStatus();
}

/// The coat's normals, where they are not those of the base.
absl::Status set_coat_normal(const v1::Material& material, const ExtendedRecord& extended,
                             MaterialSlots& slots) {
  const bool bent = material.has_normal_map() || !material.normal_texture().empty() ||
                    material.displacement().has_texture();
  if (is_zero(extended.scalars[slot::kCoat])) return absl::OkStatus();
  if (!bent && !material.gltf().has_clearcoat_normal_map()) return absl::OkStatus();
  slots.record.flags |= kUsesFurther;
  if (!material.gltf().has_clearcoat_normal_map()) return absl::OkStatus();
  return slots.set_upper_normal(material.gltf().clearcoat_normal_map());
}

}  // namespace

absl::Status set_gltf(const v1::Material& material, MaterialSlots& slots) {
  const v1::GltfMaterial& gltf = material.gltf();
  MaterialRecord& record = slots.record;
  record.kind = BsdfKind::kGltf;
  record.flags |= kUsesSecondSpectrum | kUsesAlphas | kUsesEta | kDiffuseBase;
  ExtendedRecord& extended = slots.extend();
  if (auto s = set_usual_slots(gltf, extended, slots); !s.ok()) return s;
  if (!std::isfinite(gltf.anisotropy_rotation()))
    return absl::InvalidArgumentError("its anisotropy_rotation is not finite");
  extended.scalars[slot::kRotation].value = std::fmod(gltf.anisotropy_rotation(), 360.0f) * kPi / 180;
  if (!is_zero(record.scalars[slot::kAnisotropic])) {
    record.flags |= kAnisotropic;
    if (gltf.has_anisotropy_direction()) record.flags |= kUsesFurther;
  }
  if (gltf.volume() && !is_zero(extended.scalars[slot::kTransmission])) record.flags |= kHasInside;
  record.coat_table = slots.energies().layers();
  const float index = gltf.has_ior() ? gltf.ior() : 1.5f;
  const float eta = (record.flags & kHasInside) && index == 1 ? 1 + kLeastIndexStep : index;
  record.scalars[slot::kEta].value = eta;
  if (auto s = wire::check_index(index); !s.ok()) return s;
  if (auto s = set_film(gltf, extended, slots); !s.ok()) return s;
  if (auto s = set_dispersion(gltf.dispersion(), eta, extended, slots); !s.ok()) return s;
  return set_coat_normal(material, extended, slots);
}

}  // namespace tessera::render
