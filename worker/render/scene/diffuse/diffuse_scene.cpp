#include "render/scene/diffuse/diffuse_scene.h"

#include <cstdint>
#include <set>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "render/bsdf/kinds.h"
#include "render/textbook/radiosity/memory.h"

namespace tessera::render {

namespace {

constexpr std::int32_t kKeptFlags = kHasBump | kOneSided | kHasBack | kBendsSoftly;

absl::Status check_shapes(const ShapeTable& shapes, const std::vector<std::string>& names) {
  for (std::size_t i = 0; i < shapes.shapes.size(); ++i) {
    if (shapes.shapes[i].kind == ShapeKind::kTriangles) continue;
    return absl::InvalidArgumentError(
        absl::StrCat(names[i], ": radiosity is for meshes of triangles; this is another kind of shape"));
  }
  return absl::OkStatus();
}

/// Adds a material and those that it consists of.
void collect(const MaterialTable& table, std::int32_t material, std::set<std::int32_t>& used) {
  if (material < 0 || !used.insert(material).second) return;
  const MaterialRecord& record = table.materials[static_cast<std::size_t>(material)];
  if (record.flags & kMixed) {
    collect(table, record.mix_a, used);
    collect(table, record.mix_b, used);
  }
  if (record.flags & kHasBack) collect(table, record.back, used);
}

/// Part of a material that is diffuse reflection: the slot, and how much of that.
SpectrumSlot diffuse_part(const MaterialTable& table, const MaterialRecord& record) {
  SpectrumSlot base = record.spectra[slot::kReflectance];
  if (record.kind == BsdfKind::kDiffuse) return base;
  if ((record.flags & kDiffuseBase) == 0) return {};
  if ((record.flags & kUsesExtended) == 0) return base;
  // Burley's base and glTF's: metal and glass take their shares.
  static_assert(slot::kTransmission == slot::kSpecTrans);
  const ExtendedRecord& more = table.extended[static_cast<std::size_t>(record.extended)];
  const float share = (1 - more.scalars[slot::kMetallic].value) * (1 - more.scalars[slot::kSpecTrans].value);
  if (base.texture >= 0) return share > 0.5f ? base : SpectrumSlot{};
  for (float& value : base.value) value *= share;
  return base;
}

bool is_diffuse(const MaterialRecord& record) {
  const bool scatters = record.kind == BsdfKind::kDiffuse || (record.flags & kMixed) != 0;
  return scatters && (record.flags & kHasOpacity) == 0;
}

void make_diffuse(const MaterialTable& table, MaterialRecord& record) {
  if ((record.flags & kMixed) == 0) {
    const SpectrumSlot diffuse = diffuse_part(table, record);
    record.kind = BsdfKind::kDiffuse;
    record.flags = (record.flags & kKeptFlags) | (diffuse.texture >= 0 ? kHasTextures : 0);
    record.variants = 0;
    record.spectra[slot::kReflectance] = diffuse;
    record.spectra[1] = {};
    for (ScalarSlot& scalar : record.scalars) scalar = {};
    record.coat_table = -1;
  }
  record.flags &= ~kHasOpacity;
  record.opacity = {1, -1};
}

std::uint64_t count_triangles(const ShapeTable& shapes) {
  const auto of_range = [&](std::int32_t first, std::int32_t count) {
    std::uint64_t sum = 0;
    for (std::int32_t i = first; i < first + count; ++i)
      sum += static_cast<std::uint64_t>(shapes.shapes[static_cast<std::size_t>(i)].triangle_count);
    return sum;
  };
  std::uint64_t sum = of_range(0, shapes.world_shape_count);
  for (const InstanceRecord& instance : shapes.instances) {
    const ObjectRange& object = shapes.objects[static_cast<std::size_t>(instance.object)];
    sum += of_range(object.first_shape, object.shape_count);
  }
  return sum;
}

}  // namespace

absl::Status check_radiosity_memory(std::uint64_t triangles, std::uint64_t limit) {
  constexpr std::uint64_t kMostTriangles = std::uint64_t{1} << 30;
  const std::uint64_t needed = radiosity::least_memory(2 * triangles);
  if (needed <= limit && triangles <= kMostTriangles) return absl::OkStatus();
  constexpr double kMiB = 1 << 20;
  return absl::InvalidArgumentError(
      absl::StrFormat("radiosity of %d triangles needs %.1f MiB at least, for patches on both of their sides "
                      "and %d links each; "
                      "the memory limit is %.1f MiB (--set radiosity.memory-limit)",
                      triangles, static_cast<double>(needed) / kMiB, radiosity::kLeastLinks,
                      static_cast<double>(limit) / kMiB));
}

absl::Status make_diffuse(const Settings& settings, const DiffuseSceneNames& names, SceneArrays& arrays,
                          std::vector<std::string>& warnings) {
  if (auto s = check_shapes(arrays.shapes, names.shapes); !s.ok()) return s;
  if (auto s = check_radiosity_memory(count_triangles(arrays.shapes), settings.radiosity.memory_limit);
      !s.ok())
    return s;
  std::set<std::int32_t> used;
  for (std::size_t i = 0; i < arrays.shapes.shapes.size(); ++i) {
    ShapeRecord& shape = arrays.shapes.shapes[i];
    collect(arrays.materials, shape.material, used);
    if ((shape.flags & kHasAlpha) == 0) continue;
    if (!settings.ignore_non_diffuse) {
      return absl::InvalidArgumentError(
          absl::StrCat(names.shapes[i], ": radiosity is for closed surfaces; this one has alpha below 1"));
    }
    warnings.push_back(absl::StrCat(names.shapes[i], ": alpha is left out"));
    shape.flags &= ~kHasAlpha;
    shape.alpha = 1, shape.alpha_texture = -1;
  }
  for (const std::int32_t index : used) {
    MaterialRecord& record = arrays.materials.materials[static_cast<std::size_t>(index)];
    if (is_diffuse(record)) continue;
    const std::string where =
        absl::StrCat("material '", names.materials[static_cast<std::size_t>(index)], "'");
    if (!settings.ignore_non_diffuse) {
      return absl::InvalidArgumentError(
          absl::StrCat(where,
                       ": radiosity is for diffuse materials, and this one is not: it can be left out "
                       "with --set radiosity.ignore-non-diffuse"));
    }
    make_diffuse(arrays.materials, record);
    warnings.push_back(absl::StrCat(where, ": only its diffuse reflection is seen"));
  }
  return absl::OkStatus();
}

}  // namespace tessera::render
