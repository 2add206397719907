// Materials: their names, mixes and sides, bump and normal maps.
#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "render/bsdf/slots.h"
#include "render/build/scene_builder.h"
#include "wire/limits.h"

namespace tessera::render {

namespace {

/// Step in u and v for differences of the texture at `node`: within a texel, where bilinear textures are
/// linear, and as pbrt's for those that are not made of images.
float difference_step(const TextureTable& table, int node) {
  constexpr float kPartOfTexel = 1.0f / 32, kUsual = 0.0005f;
  const TextureNode& texture = table.nodes[static_cast<std::size_t>(node)];
  float step = kUsual;
  if (texture.image) {
    const float columns = std::fabs(texture.scale_u) + std::fabs(texture.u_from_v);
    const float rows = std::fabs(texture.scale_v) + std::fabs(texture.v_from_u);
    const float texels = std::max(static_cast<float>(texture.image->width) * columns,
                                  static_cast<float>(texture.image->height) * rows);
    step = std::min(step, kPartOfTexel / std::max(texels, 1.0f));
  }
  for (const std::int32_t input : texture.inputs) {
    if (input >= 0) step = std::min(step, difference_step(table, input));
  }
  return step;
}

}  // namespace

absl::StatusOr<int> SceneBuilder::material_index(const std::string& name) const {
  if (name.empty()) return default_material_;
  const auto it = materials_.find(name);
  if (it == materials_.end())
    return absl::InvalidArgumentError(absl::StrCat("material '", name, "' does not exist"));
  return it->second;
}

absl::Status SceneBuilder::build_materials() {
  auto& records = arrays_.materials.materials;
  default_material_ = scene_.materials_size();
  for (const v1::Material& material : scene_.materials()) {
    if (!materials_.emplace(material.name(), static_cast<int>(materials_.size())).second) {
      return absl::InvalidArgumentError(
          absl::StrCat("material '", material.name(), "': the name is used twice"));
    }
  }
  for (const v1::Material& material : scene_.materials()) {
    MaterialRecord& record = records.emplace_back();
    if (auto s = build_material(material, record); !s.ok()) {
      return located(s, absl::StrCat("material '", material.name(), "'"));
    }
  }
  std::ranges::fill(records.emplace_back().spectra[slot::kReflectance].value, 0.5f);

  for (const MaterialRecord& record : records) {
    tables_.any_textures = tables_.any_textures || (record.flags & kHasTextures);
    tables_.any_tangents = tables_.any_tangents || (record.flags & (kHasBump | kAnisotropic));
    tables_.any_mix = tables_.any_mix || (record.flags & (kMixed | kHasBack));
  }
  return check_mixes();
}

absl::Status SceneBuilder::check_mixes() const {
  // Following first or second parts from a mix must end: depth-first, with the path marked. What is behind a
  // surface needs no look, as light only gets there once.
  constexpr int kUnknown = -1, kOnThePath = -2;
  const auto& records = arrays_.materials.materials;
  std::vector<int> nesting(records.size(), kUnknown);  // of what is sound: mixes within one another
  const std::function<absl::Status(int, int)> look = [&](int i, int above) {
    if (nesting[i] == kOnThePath) return absl::InvalidArgumentError("it mixes itself");
    if (!(records[i].flags & kMixed)) nesting[i] = 0;
    if (nesting[i] == kUnknown && above < wire::kMaxNesting) {
      nesting[i] = kOnThePath;
      for (const int part : {records[i].mix_a, records[i].mix_b}) {
        if (auto s = look(part, above + 1); !s.ok()) return s;
      }
      nesting[i] = 1 + std::max(nesting[records[i].mix_a], nesting[records[i].mix_b]);
    }
    if (nesting[i] != kUnknown && above + nesting[i] <= wire::kMaxNesting) return absl::OkStatus();
    return absl::InvalidArgumentError(
        absl::StrCat("more than ", wire::kMaxNesting, " mixes within one another"));
  };
  for (const auto& [name, index] : materials_) {
    if (auto s = look(index, 0); !s.ok()) return located(s, absl::StrCat("material '", name, "'"));
  }
  return absl::OkStatus();
}

absl::Status SceneBuilder::set_mix(const v1::MixMaterial& mix, MaterialRecord& record) {
  record.kind = BsdfKind::kMix;
  record.flags |= kMixed;
  const auto a = material_index(mix.a()), b = material_index(mix.b());
  if (!a.ok()) return a.status();
  if (!b.ok()) return b.status();
  record.mix_a = *a, record.mix_b = *b;
  return set_scalar(mix.amount(), 0.5f, record, record.scalars[slot::kMixAmount]);
}

absl::Status SceneBuilder::set_kind(const v1::Material& material, MaterialRecord& record) {
  switch (material.kind_case()) {
    case v1::Material::kDiffuse:
      return set_spectrum(material.diffuse().reflectance(), {0.5f, 0.5f, 0.5f}, record,
                          record.spectra[slot::kReflectance]);
    case v1::Material::kConductor:
      return set_conductor(material.conductor(), record);
    case v1::Material::kDielectric:
      return set_dielectric(material.dielectric(), record);
    case v1::Material::kThinDielectric:
      return set_thin_dielectric(material.thin_dielectric(), record);
    case v1::Material::kCoatedDiffuse:
      return set_coat(material.coated_diffuse(), material.name(), record);
    case v1::Material::kPlastic:
      return set_plastic(material.plastic(), record);
    case v1::Material::kCoatedConductor:
      return set_coated_conductor(material.coated_conductor(), material.name(), record);
    case v1::Material::kHair:
      return set_hair(material.hair(), record);
    case v1::Material::kPrincipled:
      return set_principled(material.principled(), record);
    case v1::Material::kDiffuseTransmission:
      return set_diffuse_transmission(material.diffuse_transmission(), record);
    case v1::Material::kMix:
      return set_mix(material.mix(), record);
    case v1::Material::kInterface:
      record.kind = BsdfKind::kInterface;
      record.flags |= kAllDelta | kPassesStraight;
      return absl::OkStatus();
    case v1::Material::KIND_NOT_SET:
      break;
  }
  return absl::InvalidArgumentError("its kind is missing or unknown");
}

absl::Status SceneBuilder::set_sides(const v1::Material& material, MaterialRecord& record) {
  // Principled glass has an inside, and a thin sheet no back.
  const bool both = (record.flags & kHasInside) || record.kind == BsdfKind::kPrincipledThin;
  if (material.one_sided() && !both) record.flags |= kOneSided;
  if (material.back().empty()) return absl::OkStatus();
  const auto back = material_index(material.back());
  if (!back.ok()) return back.status();
  record.back = *back;
  record.flags |= kHasBack;
  return absl::OkStatus();
}

absl::Status SceneBuilder::set_maps(const v1::Material& material, MaterialRecord& record) {
  if (material.displacement().has_texture()) {
    auto node = texture_node(material.displacement().texture());
    if (!node.ok()) return node.status();
    record.bump_texture = *node;
    record.bump_step = difference_step(arrays_.textures, *node);
    record.flags |= kHasBump;
  }
  if (material.has_normal_map() && !material.normal_texture().empty()) {
    return absl::InvalidArgumentError("normal_map and normal_texture exclude each other");
  }
  if (material.has_normal_map() || !material.normal_texture().empty()) {
    auto node = material.has_normal_map() ? normal_map_node(material.normal_map())
                                          : texture_node(material.normal_texture());
    if (!node.ok()) return node.status();
    record.normal_texture = *node;
    record.flags |= kHasBump;
  }
  if (material.bends_softly() && (record.flags & kHasBump)) record.flags |= kBendsSoftly;
  if (!material.has_opacity()) return absl::OkStatus();
  if (auto s = set_scalar(material.opacity(), 1, record, record.opacity); !s.ok()) return s;
  record.opacity.value = std::clamp(record.opacity.value, 0.0f, 1.0f);
  if (record.opacity.texture >= 0 || record.opacity.value < 1) record.flags |= kHasOpacity;
  return absl::OkStatus();
}

absl::Status SceneBuilder::build_material(const v1::Material& material, MaterialRecord& record) {
  if (auto s = set_kind(material, record); !s.ok()) return s;
  if (auto s = set_sides(material, record); !s.ok()) return s;
  return set_maps(material, record);
}

}  // namespace tessera::render
