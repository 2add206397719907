#include "render/scene/material/material_kinds.h"

#include <algorithm>
#include <cmath>

#include "render/bsdf/kinds.h"
#include "render/core/constants.h"
#include "render/scene/values/spectra.h"
#include "spectra/rgb/scene_rgb.h"
#include "spectra/upsampling/upsample.h"
#include "wire/scene_numbers.h"

namespace tessera::render {

namespace {

constexpr float kSmoothAlpha = 1e-3f;  // the same as in bsdf/microfacet.h

/// The curve of an index; of one that is no curve, that of its green.
spectra::Curve index_curve(const v1::Spectrum& spectrum) {
  if (auto measured = measured_curve(spectrum)) return *std::move(measured);
  return {{550}, {emission(spectrum).g}};
}

/// Indices of a metal of which at least one is a curve, for jobs of RGB.
spectra::ConductorRgb conductor_rgb(const v1::Spectrum& eta, const v1::Spectrum& k) {
  const auto is_color = [](const v1::Spectrum& index) {
    return index.has_in_rgb() || !measured_curve(index);
  };
  if (is_color(eta) && is_color(k)) return {emission(eta), emission(k)};
  return spectra::conductor_rgb(index_curve(eta), index_curve(k));
}

/// eta = 1, and the k with which a conductor of this normal reflectance has it [pbrt-v4].
float k_for_reflectance(float r) {
  r = std::fmin(std::fmax(r, 0.0f), 0.9999f);
  return 2 * std::sqrt(r) / std::sqrt(1 - r);
}

bool is_smooth(const MaterialRecord& record) {
  const ScalarSlot &u = record.scalars[slot::kAlphaX], &v = record.scalars[slot::kAlphaY];
  return u.texture < 0 && v.texture < 0 && std::fmax(u.value, v.value) < kSmoothAlpha;
}

/// The index with which a dielectric has the normal reflectance 0.08 * specular [Burley 2012].
float eta_from_specular(float specular) { return 2 / (1 - std::sqrt(0.08f * specular)) - 1; }

/// The curve of k_for_reflectance() of a reflectance that is in the slot.
std::int32_t k_curve(const SpectrumSlot& reflectance, SpectralBuilder& spectral) {
  if (reflectance.curve >= 0)
    return spectral.add_function_of(reflectance.curve, [](float r) { return k_for_reflectance(r); });
  const auto sigmoid =
      spectra::upsample_reflectance({reflectance.value[0], reflectance.value[1], reflectance.value[2]})
          .coefficients;
  return spectral.add_curve(
      [&](double nm) { return k_for_reflectance(spectra::value(sigmoid, static_cast<float>(nm))); });
}

absl::Status set_conductor_index(const v1::ConductorMaterial& conductor, MaterialSlots& slots) {
  MaterialRecord& record = slots.record;
  record.flags |= kUsesSecondSpectrum;
  if (conductor.has_reflectance()) {
    if (auto s = slots.set_spectrum(conductor.reflectance(), {}, record.spectra[slot::kConductorK]); !s.ok())
      return s;
    if (record.spectra[slot::kConductorK].texture >= 0) {
      // The texture is the reflectance, which the model turns into eta and k.
      record.flags |= kPrepared;
      return absl::OkStatus();
    }
    put({1, 1, 1}, record.spectra[slot::kConductorEta]);
    SpectrumSlot& k = record.spectra[slot::kConductorK];
    if (slots.spectral() != nullptr) k.curve = k_curve(k, *slots.spectral());
    for (float& value : k.value) value = k_for_reflectance(value);
    return absl::OkStatus();
  }
  const v1::Spectrum &eta = conductor.eta().constant(), &k = conductor.k().constant();
  if (measured_curve(eta) || measured_curve(k)) {
    for (const v1::Spectrum* s : {&eta, &k}) {
      if (auto status = check_spectrum(*s, "index of refraction"); !status.ok()) return status;
    }
    const spectra::ConductorRgb rgb = conductor_rgb(eta, k);
    put(rgb.eta, record.spectra[slot::kConductorEta]);
    put(rgb.k, record.spectra[slot::kConductorK]);
    if (SpectralBuilder* const spectral = slots.spectral(); spectral != nullptr) {
      for (const auto& [index, slot] :
           {std::pair(&eta, slot::kConductorEta), std::pair(&k, slot::kConductorK)}) {
        const spectra::Curve values = index_curve(*index);
        record.spectra[slot].curve = spectral->add_curve([&](double nm) { return values.at(nm); });
      }
    }
    return absl::OkStatus();
  }
  if (auto s = slots.set_spectrum(conductor.eta(), {1, 1, 1}, record.spectra[slot::kConductorEta]); !s.ok())
    return s;
  return slots.set_spectrum(conductor.k(), {1, 1, 1}, record.spectra[slot::kConductorK]);
}

absl::Status set_conductor(const v1::ConductorMaterial& conductor, MaterialSlots& slots) {
  MaterialRecord& record = slots.record;
  record.kind = BsdfKind::kConductor;
  record.flags |= kUsesAlphas;
  if (auto s = slots.set_roughness(conductor.roughness(), record.scalars[slot::kAlphaX],
                                   record.scalars[slot::kAlphaY]);
      !s.ok()) {
    return s;
  }
  if (is_smooth(record)) record.flags |= kAllDelta | kHasDeltaLobe;
  slots.set_multiple_scattering(conductor.roughness(), 0);
  if (conductor.has_tint()) {
    if (auto s = slots.set_tint(conductor.tint(), slots.extend().spectra[slot::kConductorTint]); !s.ok())
      return s;
  }
  return set_conductor_index(conductor, slots);
}

absl::Status set_dielectric(const v1::DielectricMaterial& dielectric, MaterialSlots& slots) {
  MaterialRecord& record = slots.record;
  record.kind = BsdfKind::kDielectric;
  record.flags |= kUsesAlphas | kUsesEta | kTransmits;
  if (auto s = slots.set_dispersing_eta(dielectric.eta(), dielectric.has_dispersion(),
                                        dielectric.dispersion(), 1.5f);
      !s.ok()) {
    return s;
  }
  if (auto s = slots.set_tint(dielectric.reflection_tint(), record.spectra[slot::kReflectionTint]); !s.ok())
    return s;
  if (auto s = slots.set_tint(dielectric.transmission_tint(), record.spectra[slot::kTransmissionTint]);
      !s.ok())
    return s;
  if (record.variants & kTinted) record.flags |= kUsesSecondSpectrum;
  if (auto s = slots.set_roughness(dielectric.roughness(), record.scalars[slot::kAlphaX],
                                   record.scalars[slot::kAlphaY]);
      !s.ok()) {
    return s;
  }
  if (is_smooth(record)) record.flags |= kAllDelta | kHasDeltaLobe;
  slots.set_multiple_scattering(dielectric.roughness(), record.scalars[slot::kEta].value);
  return absl::OkStatus();
}

absl::Status set_thin_dielectric(const v1::ThinDielectricMaterial& sheet, MaterialSlots& slots) {
  MaterialRecord& record = slots.record;
  record.kind = BsdfKind::kThinDielectric;
  record.flags |= kAllDelta | kHasDeltaLobe | kUsesEta | kTransmits;
  if (sheet.passes_straight()) record.flags |= kPassesStraight;
  if (auto s = slots.set_dispersing_eta(sheet.eta(), sheet.has_dispersion(), sheet.dispersion(), 1.5f);
      !s.ok()) {
    return s;
  }
  if (auto s = slots.set_tint(sheet.reflection_tint(), record.spectra[slot::kReflectionTint]); !s.ok())
    return s;
  if (auto s = slots.set_tint(sheet.transmission_tint(), record.spectra[slot::kTransmissionTint]); !s.ok())
    return s;
  if (record.variants & kTinted) record.flags |= kUsesSecondSpectrum;
  return absl::OkStatus();
}

absl::Status set_coat(const v1::CoatedDiffuseMaterial& coat, MaterialSlots& slots) {
  MaterialRecord& record = slots.record;
  record.kind = BsdfKind::kCoatedDiffuse;
  record.flags |= kUsesAlphas | kUsesEta | kDiffuseBase;
  if (auto s = slots.set_coat_eta(coat.eta(), 1.5f); !s.ok()) return s;
  if (auto s = slots.set_spectrum(coat.reflectance(), {0.5f, 0.5f, 0.5f}, record.spectra[slot::kReflectance]);
      !s.ok())
    return s;
  if (auto s =
          slots.set_roughness(coat.roughness(), record.scalars[slot::kAlphaX], record.scalars[slot::kAlphaY]);
      !s.ok()) {
    return s;
  }
  if (is_smooth(record)) record.flags |= kHasDeltaLobe;
  const float thickness = coat.has_thickness() ? coat.thickness() : 0;
  if (!(thickness >= 0) || !std::isfinite(thickness))
    return absl::InvalidArgumentError("the thickness of its coat is below 0");
  record.coat_table = slots.energies().coat(record.scalars[slot::kEta].value, thickness);
  const spectra::Rgb albedo = reflectance(coat.albedo().constant());
  if (coat.albedo().has_texture() || albedo.r > 0 || albedo.g > 0 || albedo.b > 0) {
    slots.warn("the medium inside its coat is left out");
  }
  return absl::OkStatus();
}

absl::Status set_plastic(const v1::PlasticMaterial& plastic, MaterialSlots& slots) {
  MaterialRecord& record = slots.record;
  constexpr float kUsualEta = 1.5046f / 1.000277f;
  record.kind = BsdfKind::kPlastic;
  record.flags |= kUsesSecondSpectrum | kUsesAlphas | kUsesEta | kDiffuseBase;
  if (plastic.nonlinear()) set_variants(record, kNonlinear);
  if (auto s = slots.set_coat_eta(plastic.eta(), kUsualEta); !s.ok()) return s;
  if (auto s =
          slots.set_spectrum(plastic.reflectance(), {0.5f, 0.5f, 0.5f}, record.spectra[slot::kReflectance]);
      !s.ok())
    return s;
  if (auto s = slots.set_tint(plastic.tint(), record.spectra[slot::kCoatTint]); !s.ok()) return s;
  ScalarSlot &u = record.scalars[slot::kAlphaX], &v = record.scalars[slot::kAlphaY];
  if (auto s = slots.set_roughness(plastic.roughness(), u, v); !s.ok()) return s;
  if (u.texture >= 0 || v.texture >= 0 || u.value != v.value) {
    return absl::InvalidArgumentError(
        "the roughness of a plastic must be constant and the same along u and v");
  }
  if (is_smooth(record)) {
    u.value = v.value = 0;
    record.flags |= kHasDeltaLobe;
  }
  const BoundaryFacets facets{u.value, (record.variants & kBeckmann) != 0,
                              (record.variants & kSeparableMasking) != 0};
  record.coat_table = slots.energies().plastic(record.scalars[slot::kEta].value, facets);
  return absl::OkStatus();
}

absl::Status set_coated_conductor(const v1::CoatedConductorMaterial& coated, MaterialSlots& slots) {
  MaterialRecord& record = slots.record;
  record.kind = BsdfKind::kCoatedConductor;
  record.flags |= kUsesAlphas | kUsesEta;
  ScalarSlot &u = record.scalars[slot::kAlphaX], &v = record.scalars[slot::kAlphaY];
  if (auto s = slots.set_coat_eta(coated.eta(), 1.5f); !s.ok()) return s;
  if (auto s = slots.set_roughness(coated.roughness(), u, v); !s.ok()) return s;
  ExtendedRecord& extended = slots.extend();
  const v1::Roughness& base = coated.conductor().roughness();
  if (auto s =
          slots.set_roughness(base, extended.scalars[slot::kBaseAlphaX], extended.scalars[slot::kBaseAlphaY]);
      !s.ok())
    return s;
  const bool smooth_base = extended.scalars[slot::kBaseAlphaX].texture < 0 &&
                           extended.scalars[slot::kBaseAlphaY].texture < 0 &&
                           std::fmax(extended.scalars[slot::kBaseAlphaX].value,
                                     extended.scalars[slot::kBaseAlphaY].value) < kSmoothAlpha;
  if (is_smooth(record)) record.flags |= smooth_base ? kAllDelta | kHasDeltaLobe : kHasDeltaLobe;
  if (record.variants & (kBeckmann | kSeparableMasking)) {
    record.variants &= ~(kBeckmann | kSeparableMasking);
    slots.warn("its microfacets are GGX with correlated masking");
  }
  const float thickness = coated.has_thickness() ? coated.thickness() : 0;
  if (!(thickness >= 0) || !std::isfinite(thickness))
    return absl::InvalidArgumentError("the thickness of its coat is below 0");
  extended.scalars[slot::kThickness].value = thickness;
  const spectra::Rgb albedo = reflectance(coated.albedo().constant());
  if (coated.albedo().has_texture() || albedo.r > 0 || albedo.g > 0 || albedo.b > 0) {
    slots.warn("the medium inside its coat only absorbs");
  }
  if (coated.conductor().has_tint()) {
    slots.warn("the tint of its conductor is left out");
  }
  return set_conductor_index(coated.conductor(), slots);
}

absl::Status set_hair(const v1::HairMaterial& hair, MaterialSlots& slots) {
  MaterialRecord& record = slots.record;
  // Brown hair, for want of anything else: 1.3 times the absorption of eumelanin [d'Eon et al. 2011].
  constexpr spectra::Rgb kBrown{0.5447f, 0.9061f, 1.781f};
  record.kind = BsdfKind::kHair;
  record.flags |= kUsesAlphas | kUsesEta | kAnisotropic | kPrepared | kTransmits;
  if (!hair.has_sigma_a() && hair.has_reflectance()) {
    set_variants(record, kHairReflectance);
    if (auto s = slots.set_spectrum(hair.reflectance(), {}, record.spectra[slot::kAbsorption]); !s.ok())
      return s;
  } else if (auto s = slots.set_spectrum(hair.sigma_a(), kBrown, record.spectra[slot::kAbsorption]);
             !s.ok()) {
    return s;
  }
  if (auto s = slots.set_scalar(hair.beta_m(), 0.3f, record.scalars[slot::kBetaM]); !s.ok()) return s;
  if (auto s = slots.set_scalar(hair.beta_n(), 0.3f, record.scalars[slot::kBetaN]); !s.ok()) return s;
  const float eta = hair.has_eta() ? hair.eta() : 1.55f;
  if (auto s = wire::check_index(eta); !s.ok()) return s;
  record.scalars[slot::kEta].value = eta;
  const float degrees = hair.has_alpha_degrees() ? hair.alpha_degrees() : 2;
  if (!std::isfinite(degrees)) return absl::InvalidArgumentError("the tilt of its scales is not finite");
  slots.extend().scalars[slot::kTilt].value = degrees * kPi / 180;
  return absl::OkStatus();
}

absl::Status set_principled(const v1::PrincipledMaterial& principled, MaterialSlots& slots) {
  MaterialRecord& record = slots.record;
  record.kind = principled.thin() ? BsdfKind::kPrincipledThin : BsdfKind::kPrincipled;
  record.flags |= kUsesAlphas | kUsesEta | kDiffuseBase;
  if (principled.thin()) record.flags |= kTransmits | kSheet;
  set_variants(record, kSeparableMasking);
  ExtendedRecord& extended = slots.extend();
  const struct {
    const v1::FloatValue& value;
    float otherwise;
    ScalarSlot& target;
  } scalars[] = {{principled.roughness(), 0.5f, record.scalars[slot::kRoughness]},
                 {principled.anisotropic(), 0, record.scalars[slot::kAnisotropic]},
                 {principled.specular(), 0.5f, record.scalars[slot::kEta]},
                 {principled.metallic(), 0, extended.scalars[slot::kMetallic]},
                 {principled.spec_trans(), 0, extended.scalars[slot::kSpecTrans]},
                 {principled.spec_tint(), 0, extended.scalars[slot::kSpecTint]},
                 {principled.sheen(), 0, extended.scalars[slot::kSheen]},
                 {principled.sheen_tint(), 0, extended.scalars[slot::kSheenTint]},
                 {principled.flatness(), 0, extended.scalars[slot::kFlatness]},
                 {principled.clearcoat(), 0, extended.scalars[slot::kClearcoat]},
                 {principled.clearcoat_gloss(), 0, extended.scalars[slot::kClearcoatGloss]},
                 {principled.diff_trans(), 0, extended.scalars[slot::kDiffTrans]}};
  for (const auto& [value, otherwise, target] : scalars) {
    if (auto s = slots.set_scalar(value, otherwise, target); !s.ok()) return s;
    // Treated like the textured ones; the index is not one of these yet.
    const float highest = &target == &extended.scalars[slot::kDiffTrans] ? 2.0f : 1.0f;
    if (&target != &record.scalars[slot::kEta]) target.value = std::clamp(target.value, 0.0f, highest);
  }
  if (auto s =
          slots.set_spectrum(principled.base_color(), {0.5f, 0.5f, 0.5f}, record.spectra[slot::kReflectance]);
      !s.ok())
    return s;
  if (!is_zero(record.scalars[slot::kAnisotropic])) record.flags |= kAnisotropic;
  const bool transmits = !principled.thin() && !is_zero(extended.scalars[slot::kSpecTrans]);
  if (transmits) record.flags |= kHasInside;

  // Nothing is refracted where the index does not change: a little, then.
  ScalarSlot& eta = record.scalars[slot::kEta];
  if (principled.has_eta()) {
    eta = {transmits && principled.eta() == 1 ? 1.001f : principled.eta(), -1};
  } else if (eta.texture >= 0) {
    record.flags |= kPrepared;
  } else {
    if (eta.value < 0 || eta.value > 1)
      return absl::InvalidArgumentError("its specular is not between 0 and 1");
    eta.value = eta_from_specular(transmits && eta.value == 0 ? 1e-3f : eta.value);
  }
  return eta.texture >= 0 ? absl::OkStatus() : wire::check_index(eta.value);
}

absl::Status set_phong(const v1::PhongMaterial& phong, MaterialSlots& slots) {
  MaterialRecord& record = slots.record;
  record.kind = BsdfKind::kPhong;
  record.flags |= kUsesSecondSpectrum | kUsesEta | kDiffuseBase;
  if (phong.lobe() == v1::PhongMaterial::BLINN) set_variants(record, kBlinn);
  if (phong.lobe() == v1::PhongMaterial::MIRROR) {
    set_variants(record, kMirrorLobe);
    record.flags |= kHasDeltaLobe;
  }
  if (auto s = slots.set_spectrum(phong.diffuse(), {0.5f, 0.5f, 0.5f}, record.spectra[slot::kReflectance]);
      !s.ok())
    return s;
  if (auto s = slots.set_spectrum(phong.specular(), {0.2f, 0.2f, 0.2f}, record.spectra[slot::kGloss]);
      !s.ok())
    return s;
  return slots.set_scalar(phong.exponent(), 30, record.scalars[slot::kExponent]);
}

absl::Status set_diffuse_transmission(const v1::DiffuseTransmissionMaterial& material, MaterialSlots& slots) {
  MaterialRecord& record = slots.record;
  record.kind = BsdfKind::kDiffuseTransmission;
  record.flags |= kUsesSecondSpectrum | kTransmits | kDiffuseBase;
  if (auto s = slots.set_spectrum(material.reflectance(), {0.25f, 0.25f, 0.25f},
                                  record.spectra[slot::kReflectance]);
      !s.ok())
    return s;
  if (auto s = slots.set_spectrum(material.transmittance(), {0.25f, 0.25f, 0.25f},
                                  record.spectra[slot::kTransmittance]);
      !s.ok())
    return s;
  const float scale = material.has_scale() ? material.scale() : 1;
  if (!std::isfinite(scale)) return absl::InvalidArgumentError("its scale is not finite");
  slots.scale_spectra(scale);
  return absl::OkStatus();
}

}  // namespace

absl::Status set_kind(const v1::Material& material, MaterialSlots& slots) {
  MaterialRecord& record = slots.record;
  switch (material.kind_case()) {
    case v1::Material::kDiffuse:
      return slots.set_spectrum(material.diffuse().reflectance(), {0.5f, 0.5f, 0.5f},
                                record.spectra[slot::kReflectance]);
    case v1::Material::kConductor:
      return set_conductor(material.conductor(), slots);
    case v1::Material::kDielectric:
      return set_dielectric(material.dielectric(), slots);
    case v1::Material::kThinDielectric:
      return set_thin_dielectric(material.thin_dielectric(), slots);
    case v1::Material::kCoatedDiffuse:
      return set_coat(material.coated_diffuse(), slots);
    case v1::Material::kPlastic:
      return set_plastic(material.plastic(), slots);
    case v1::Material::kCoatedConductor:
      return set_coated_conductor(material.coated_conductor(), slots);
    case v1::Material::kHair:
      return set_hair(material.hair(), slots);
    case v1::Material::kPrincipled:
      return set_principled(material.principled(), slots);
    case v1::Material::kDiffuseTransmission:
      return set_diffuse_transmission(material.diffuse_transmission(), slots);
    case v1::Material::kPhong:
      return set_phong(material.phong(), slots);
    case v1::Material::kGltf:
      return set_gltf(material, slots);
    case v1::Material::kInterface:
      record.kind = BsdfKind::kInterface;
      record.flags |= kAllDelta | kPassesStraight;
      return absl::OkStatus();
    case v1::Material::kMix:
    case v1::Material::KIND_NOT_SET:
      break;
  }
  return absl::InvalidArgumentError("its kind is missing or unknown");
}

}  // namespace tessera::render
