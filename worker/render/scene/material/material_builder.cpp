#include "render/scene/material/material_builder.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "absl/strings/str_cat.h"
#include "render/bsdf/kinds.h"
#include "render/scene/material/material_kinds.h"
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

std::string place_of(const v1::Material& material) {
  return absl::StrCat("material '", material.name(), "'");
}

}  // namespace

absl::Status MaterialBuilder::build(const Materials& materials) {
  FaultList faults(1);
  build(materials, faults);
  return faults.first();
}

void MaterialBuilder::build(const Materials& materials, FaultList& faults) {
  names_ = NameTable("material", materials.size());
  for (int i = 0; i < materials.size(); ++i)
    faults.add(materials[i], place_of(materials[i]), names_.add(materials[i].name(), i));
  for (const v1::Material& material : materials) {
    if (faults.full()) return;
    MaterialRecord& record = table_.materials.emplace_back();
    if (!faults.add(material, place_of(material), build_material(material, record))) record = {};
  }
  std::ranges::fill(table_.materials.emplace_back().spectra[slot::kReflectance].value, 0.5f);
  check_mixes(materials, faults);
}

absl::Status MaterialBuilder::build_material(const v1::Material& material, MaterialRecord& record) {
  const MaterialInputs inputs{textures_, energies_, table_, warnings_, spectral_};
  MaterialSlots slots(inputs, material.name(), record);
  if (auto s = material.has_mix() ? set_mix(material.mix(), slots) : set_kind(material, slots); !s.ok())
    return s;
  if (auto s = set_sides(material, record); !s.ok()) return s;
  return set_maps(material, slots);
}

void MaterialBuilder::check_mixes(const Materials& materials, FaultList& faults) const {
  // Following first or second parts from a mix must end: depth-first, with the path marked. What is behind a
  // surface needs no look, as light only gets there once.
  constexpr int kUnknown = -1, kOnThePath = -2, kFaulty = -3;
  const auto& records = table_.materials;
  std::vector<int> nesting(records.size(), kUnknown);  // levels of mixes within one another, where sound
  const std::function<absl::Status(int, int)> look = [&](int i, int above) {
    if (nesting[i] == kOnThePath) return absl::InvalidArgumentError("it mixes itself");
    if (nesting[i] == kFaulty) return fault_is_told();
    if (!(records[i].flags & kMixed)) nesting[i] = 0;
    if (nesting[i] == kUnknown && above < wire::kMaxNesting) {
      nesting[i] = kOnThePath;
      for (const int part : {records[i].mix_a, records[i].mix_b}) {
        if (auto s = look(part, above + 1); !s.ok()) {
          nesting[i] = kFaulty;
          return s;
        }
      }
      nesting[i] = 1 + std::max(nesting[records[i].mix_a], nesting[records[i].mix_b]);
    }
    if (nesting[i] != kUnknown && above + nesting[i] <= wire::kMaxNesting) return absl::OkStatus();
    if (nesting[i] > wire::kMaxNesting) nesting[i] = kFaulty;
    return absl::InvalidArgumentError(
        absl::StrCat("more than ", wire::kMaxNesting, " mixes within one another"));
  };
  for (const auto& [name, index] : names_.indices()) {
    if (faults.full()) return;
    faults.add(materials[index], place_of(materials[index]), look(index, 0));
  }
}

absl::Status MaterialBuilder::set_mix(const v1::MixMaterial& mix, MaterialSlots& slots) {
  MaterialRecord& record = slots.record;
  record.kind = BsdfKind::kMix;
  record.flags |= kMixed;
  const auto a = names_.find(mix.a()), b = names_.find(mix.b());
  if (!a.ok()) return a.status();
  if (!b.ok()) return b.status();
  record.mix_a = *a, record.mix_b = *b;
  return slots.set_scalar(mix.amount(), 0.5f, record.scalars[slot::kMixAmount]);
}

absl::Status MaterialBuilder::set_sides(const v1::Material& material, MaterialRecord& record) {
  // Principled glass has an inside, and a thin sheet no back.
  if (material.one_sided() && !(record.flags & (kHasInside | kSheet))) record.flags |= kOneSided;
  if (material.back().empty()) return absl::OkStatus();
  const auto back = names_.find(material.back());
  if (!back.ok()) return back.status();
  record.back = *back;
  record.flags |= kHasBack;
  return absl::OkStatus();
}

absl::Status MaterialBuilder::set_maps(const v1::Material& material, MaterialSlots& slots) {
  MaterialRecord& record = slots.record;
  if (material.displacement().has_texture()) {
    // Mitsuba's heights are differentiated where they are, others over a footprint.
    auto node = material.bends_softly() ? textures_.exact_node(material.displacement().texture())
                                        : textures_.filtered_node(material.displacement().texture());
    if (!node.ok()) return node.status();
    record.bump_texture = *node;
    record.bump_step = difference_step(textures_.table(), *node);
    record.flags |= kHasBump;
  }
  if (material.has_normal_map() && !material.normal_texture().empty()) {
    return absl::InvalidArgumentError("normal_map and normal_texture exclude each other");
  }
  if (material.has_normal_map() || !material.normal_texture().empty()) {
    auto node = material.has_normal_map() ? textures_.normal_map(material.normal_map())
                                          : textures_.node(material.normal_texture());
    if (!node.ok()) return node.status();
    record.normal_texture = *node;
    record.flags |= kHasBump;
  }
  if (material.bends_softly() && (record.flags & kHasBump)) record.flags |= kBendsSoftly;
  if (!material.has_opacity()) return absl::OkStatus();
  return slots.set_opacity(material.opacity());
}

}  // namespace tessera::render
