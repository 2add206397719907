#include <algorithm>
#include <cmath>

#include "render/bsdf/slots.h"
#include "render/build/material/material_kinds.h"
#include "render/core/constants.h"

namespace tessera::render {

absl::Status set_gltf(const v1::GltfMaterial& gltf, MaterialSlots& slots) {
  MaterialRecord& record = slots.record;
  record.kind = BsdfKind::kGltf;
  record.flags |= kUsesSecondSpectrum | kUsesAlphas | kUsesEta;
  ExtendedRecord& extended = slots.extend();
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
                 {gltf.diffuse_transmission(), 0, extended.scalars[slot::kBehind]}};
  for (const auto& [value, otherwise, target] : scalars) {
    if (auto s = slots.set_scalar(value, otherwise, target); !s.ok()) return s;
    target.value = std::clamp(target.value, 0.0f, 1.0f);
  }
  const struct {
    const v1::SpectrumValue& value;
    float otherwise;
    SpectrumSlot& target;
  } spectra[] = {{gltf.base_color(), 1, record.spectra[slot::kReflectance]},
                 {gltf.specular_color(), 1, record.spectra[slot::kSpecularColor]},
                 {gltf.sheen_color(), 0, extended.spectra[slot::kSheenColor]},
                 {gltf.diffuse_transmission_color(), 1, extended.spectra[slot::kBehindColor]}};
  for (const auto& [value, otherwise, target] : spectra) {
    if (auto s = slots.set_spectrum(value, {otherwise, otherwise, otherwise}, target); !s.ok()) return s;
  }
  if (!std::isfinite(gltf.anisotropy_rotation()))
    return absl::InvalidArgumentError("its anisotropy_rotation is not finite");
  extended.scalars[slot::kRotation].value = std::fmod(gltf.anisotropy_rotation(), 360.0f) * kPi / 180;
  if (!is_zero(record.scalars[slot::kAnisotropic])) record.flags |= kAnisotropic;
  if (gltf.volume() && !is_zero(extended.scalars[slot::kTransmission])) record.flags |= kHasInside;
  record.coat_table = slots.energies().layers();
  // Nothing is refracted where the index does not change: a little, then.
  const float eta = gltf.has_ior() ? gltf.ior() : 1.5f;
  record.scalars[slot::kEta].value = (record.flags & kHasInside) && eta == 1 ? 1.001f : eta;
  return check_eta(eta);
}

}  // namespace tessera::render
