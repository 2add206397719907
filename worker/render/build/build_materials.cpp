#include <cmath>

#include "absl/strings/str_cat.h"
#include "render/bsdf/coat_table.h"
#include "render/build/scene_builder.h"

namespace tessera::render {

namespace {

// Slots of the models, see the files in bsdf/.
constexpr int kAlphaU = 0, kAlphaV = 1, kEta = 2, kMixAmount = 0;

void put(const Rgb& rgb, SpectrumSlot& slot) { slot.value[0] = rgb.r, slot.value[1] = rgb.g, slot.value[2] = rgb.b; }

SampledCurve curve(const v1::Spectrum& spectrum) {
  if (spectrum.has_sampled()) {
    const auto& s = spectrum.sampled();
    return {{s.wavelengths_nm().begin(), s.wavelengths_nm().end()}, {s.values().begin(), s.values().end()}};
  }
  return {{550}, {emission(spectrum).g}};
}

float index_of_refraction(const v1::Spectrum& eta) {
  if (eta.kind_case() == v1::Spectrum::KIND_NOT_SET) return 1.5f;
  return eta.has_sampled() ? dielectric_eta(curve(eta)) : emission(eta).g;
}

absl::Status check_eta(float eta) {
  if (eta > 0 && std::isfinite(eta)) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat("an index of refraction of ", eta, " is not above 0"));
}

std::int32_t slots_used(BsdfKind kind) {
  switch (kind) {
    case BsdfKind::kConductor: return kUsesSecondSpectrum | kUsesAlphas;
    case BsdfKind::kDielectric: return kUsesAlphas | kUsesEta;
    case BsdfKind::kThinDielectric: return kUsesEta;
    case BsdfKind::kCoatedDiffuse: return kUsesAlphas | kUsesEta;
    case BsdfKind::kDiffuseTransmission: return kUsesSecondSpectrum;
    default: return 0;
  }
}

/// eta = 1, and the k with which a conductor of this normal reflectance has it [pbrt-v4].
float k_for_reflectance(float r) {
  r = std::fmin(std::fmax(r, 0.0f), 0.9999f);
  return 2 * std::sqrt(r) / std::sqrt(1 - r);
}

}  // namespace

absl::StatusOr<int> SceneBuilder::material_index(const std::string& name) const {
  if (name.empty()) return default_material_;
  const auto it = materials_.find(name);
  if (it == materials_.end()) return absl::InvalidArgumentError(absl::StrCat("material '", name, "' does not exist"));
  return it->second;
}

absl::Status SceneBuilder::build_materials() {
  auto& records = tables_.materials.materials;
  default_material_ = scene_.materials_size();
  for (const v1::Material& material : scene_.materials()) {
    if (!materials_.emplace(material.name(), static_cast<int>(materials_.size())).second) {
      return absl::InvalidArgumentError(absl::StrCat("material '", material.name(), "': the name is used twice"));
    }
  }
  for (const v1::Material& material : scene_.materials()) {
    MaterialRecord& record = records.emplace_back();
    if (auto s = build_material(material, record); !s.ok()) {
      return located(s, absl::StrCat("material '", material.name(), "'"));
    }
  }
  put({0.5f, 0.5f, 0.5f}, records.emplace_back().spectra[0]);

  for (const MaterialRecord& record : records) {
    tables_.any_textures = tables_.any_textures || (record.flags & kHasTextures);
    tables_.any_tangents = tables_.any_tangents || (record.flags & (kHasBump | kAnisotropic));
    tables_.any_mix = tables_.any_mix || record.kind == BsdfKind::kMix;
  }
  return check_mixes();
}

absl::Status SceneBuilder::check_mixes() const {
  // Following first or second parts from a mix must end: depth-first, with the path marked.
  const auto& records = tables_.materials.materials;
  std::vector<int> state(records.size(), 0);  // 1: on the path, 2: sound
  const std::function<bool(int)> sound = [&](int i) {
    if (state[i] == 1) return false;
    if (state[i] == 2 || records[i].kind != BsdfKind::kMix) return true;
    state[i] = 1;
    const bool ok = sound(records[i].mix_a) && sound(records[i].mix_b);
    state[i] = 2;
    return ok;
  };
  for (const auto& [name, index] : materials_) {
    if (!sound(index)) return absl::InvalidArgumentError(absl::StrCat("material '", name, "': it mixes itself"));
  }
  return absl::OkStatus();
}

absl::Status SceneBuilder::set_spectrum(const v1::SpectrumValue& value, const Rgb& otherwise, MaterialRecord& record,
                                        int slot) {
  if (value.has_texture()) {
    auto node = texture_node(value.texture());
    if (!node.ok()) return node.status();
    record.spectra[slot].texture = *node;
    record.flags |= kHasTextures;
    return absl::OkStatus();
  }
  if (auto s = check_spectrum(value.constant(), "spectrum"); !s.ok()) return s;
  put(value.has_constant() ? reflectance(value.constant()) : otherwise, record.spectra[slot]);
  return absl::OkStatus();
}

absl::Status SceneBuilder::set_scalar(const v1::FloatValue& value, float otherwise, MaterialRecord& record, int slot) {
  if (value.has_texture()) {
    auto node = texture_node(value.texture());
    if (!node.ok()) return node.status();
    record.scalars[slot].texture = *node;
    record.flags |= kHasTextures;
    return absl::OkStatus();
  }
  const float constant = value.has_constant() ? value.constant() : otherwise;
  if (!std::isfinite(constant)) return absl::InvalidArgumentError("a parameter is not finite");
  record.scalars[slot].value = constant;
  return absl::OkStatus();
}

absl::Status SceneBuilder::set_roughness(const v1::Roughness& roughness, MaterialRecord& record) {
  if (auto s = set_scalar(roughness.u(), 0, record, kAlphaU); !s.ok()) return s;
  if (auto s = set_scalar(roughness.v(), 0, record, kAlphaV); !s.ok()) return s;
  if (roughness.remap()) record.flags |= kRemapAlpha;
  for (const int slot : {kAlphaU, kAlphaV}) {
    ScalarSlot& alpha = record.scalars[slot];
    if (alpha.texture >= 0) continue;
    if (alpha.value < 0) return absl::InvalidArgumentError("a roughness is below 0");
    if (roughness.remap()) alpha.value = std::sqrt(alpha.value);
    alpha.value = std::fmin(alpha.value, 1.0f);
  }
  const ScalarSlot &u = record.scalars[kAlphaU], &v = record.scalars[kAlphaV];
  if (u.texture != v.texture || (u.texture < 0 && u.value != v.value)) record.flags |= kAnisotropic;
  return absl::OkStatus();
}

absl::Status SceneBuilder::set_conductor(const v1::ConductorMaterial& conductor, MaterialRecord& record) {
  record.kind = BsdfKind::kConductor;
  if (auto s = set_roughness(conductor.roughness(), record); !s.ok()) return s;
  if (conductor.has_reflectance()) {
    if (conductor.reflectance().has_texture()) {
      // The texture is the reflectance; interact() turns it into eta and k.
      record.flags |= kConductorReflectance;
      return set_spectrum(conductor.reflectance(), {}, record, 1);
    }
    if (auto s = set_spectrum(conductor.reflectance(), {}, record, 1); !s.ok()) return s;
    put({1, 1, 1}, record.spectra[0]);
    for (float& k : record.spectra[1].value) k = k_for_reflectance(k);
    return absl::OkStatus();
  }
  const v1::Spectrum &eta = conductor.eta().constant(), &k = conductor.k().constant();
  if (eta.has_sampled() || k.has_sampled()) {
    for (const v1::Spectrum* s : {&eta, &k}) {
      if (auto status = check_spectrum(*s, "index of refraction"); !status.ok()) return status;
    }
    const ConductorRgb rgb = conductor_rgb(curve(eta), curve(k));
    put(rgb.eta, record.spectra[0]);
    put(rgb.k, record.spectra[1]);
    return absl::OkStatus();
  }
  if (auto s = set_spectrum(conductor.eta(), {1, 1, 1}, record, 0); !s.ok()) return s;
  return set_spectrum(conductor.k(), {1, 1, 1}, record, 1);
}

absl::Status SceneBuilder::set_coat(const v1::CoatedDiffuseMaterial& coat, const std::string& name,
                                    MaterialRecord& record) {
  record.kind = BsdfKind::kCoatedDiffuse;
  const float eta = index_of_refraction(coat.eta());
  if (auto s = check_eta(eta); !s.ok()) return s;
  if (auto s = set_spectrum(coat.reflectance(), {0.5f, 0.5f, 0.5f}, record, 0); !s.ok()) return s;
  if (auto s = set_roughness(coat.roughness(), record); !s.ok()) return s;
  record.scalars[kEta].value = eta;
  record.coat_table = append_coat_table(eta, tables_.materials);
  const Rgb albedo = reflectance(coat.albedo().constant());
  if (coat.albedo().has_texture() || albedo.r > 0 || albedo.g > 0 || albedo.b > 0) {
    warnings_.push_back(absl::StrCat("material '", name, "': the medium inside its coat is left out"));
  }
  return absl::OkStatus();
}

absl::Status SceneBuilder::set_diffuse_transmission(const v1::DiffuseTransmissionMaterial& material,
                                                    MaterialRecord& record) {
  record.kind = BsdfKind::kDiffuseTransmission;
  if (auto s = set_spectrum(material.reflectance(), {0.25f, 0.25f, 0.25f}, record, 0); !s.ok()) return s;
  if (auto s = set_spectrum(material.transmittance(), {0.25f, 0.25f, 0.25f}, record, 1); !s.ok()) return s;
  const float scale = material.has_scale() ? material.scale() : 1;
  if (!std::isfinite(scale)) return absl::InvalidArgumentError("its scale is not finite");
  for (SpectrumSlot& slot : record.spectra) {
    if (slot.texture >= 0 && scale != 1) {
      TextureNode factor, product;
      for (float& v : factor.value) v = scale;
      product.kind = TextureKind::kScale;
      product.inputs[0] = slot.texture;
      product.inputs[1] = static_cast<int>(tables_.textures.nodes.size());
      tables_.textures.nodes.push_back(factor);
      tables_.textures.nodes.push_back(product);
      slot.texture = product.inputs[1] + 1;
    }
    for (float& v : slot.value) v *= scale;
  }
  return absl::OkStatus();
}

absl::Status SceneBuilder::build_material(const v1::Material& material, MaterialRecord& record) {
  absl::Status status;
  switch (material.kind_case()) {
    case v1::Material::kDiffuse:
      status = set_spectrum(material.diffuse().reflectance(), {0.5f, 0.5f, 0.5f}, record, 0);
      break;
    case v1::Material::kConductor: status = set_conductor(material.conductor(), record); break;
    case v1::Material::kDielectric:
      record.kind = BsdfKind::kDielectric;
      record.scalars[kEta].value = index_of_refraction(material.dielectric().eta());
      status = check_eta(record.scalars[kEta].value);
      if (status.ok()) status = set_roughness(material.dielectric().roughness(), record);
      break;
    case v1::Material::kThinDielectric:
      record.kind = BsdfKind::kThinDielectric;
      record.flags |= kAllDelta;
      record.scalars[kEta].value = index_of_refraction(material.thin_dielectric().eta());
      status = check_eta(record.scalars[kEta].value);
      break;
    case v1::Material::kCoatedDiffuse: status = set_coat(material.coated_diffuse(), material.name(), record); break;
    case v1::Material::kDiffuseTransmission:
      status = set_diffuse_transmission(material.diffuse_transmission(), record);
      break;
    case v1::Material::kMix: {
      record.kind = BsdfKind::kMix;
      const auto a = material_index(material.mix().a()), b = material_index(material.mix().b());
      if (!a.ok()) return a.status();
      if (!b.ok()) return b.status();
      record.mix_a = *a, record.mix_b = *b;
      status = set_scalar(material.mix().amount(), 0.5f, record, kMixAmount);
      break;
    }
    case v1::Material::kInterface: record.kind = BsdfKind::kInterface; break;
    case v1::Material::KIND_NOT_SET: return absl::InvalidArgumentError("its kind is missing or unknown");
  }
  if (!status.ok()) return status;
  record.flags |= slots_used(record.kind);

  // Smooth surfaces cannot be lit by sampling lights.
  const bool smooth = record.scalars[kAlphaU].texture < 0 && record.scalars[kAlphaV].texture < 0 &&
                      std::fmax(record.scalars[kAlphaU].value, record.scalars[kAlphaV].value) < 1e-3f;
  if (smooth && (record.kind == BsdfKind::kConductor || record.kind == BsdfKind::kDielectric)) record.flags |= kAllDelta;

  if (material.has_displacement() && material.displacement().has_texture()) {
    auto node = texture_node(material.displacement().texture());
    if (!node.ok()) return node.status();
    record.bump_texture = *node;
    record.flags |= kHasBump;
  }
  if (material.has_normal_map()) {
    auto node = normal_map_node(material.normal_map());
    if (!node.ok()) return node.status();
    record.normal_texture = *node;
    record.flags |= kHasBump;
  }
  return absl::OkStatus();
}

}  // namespace tessera::render
