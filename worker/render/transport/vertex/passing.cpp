#include "render/transport/vertex/passing.h"

#include "render/bsdf/material_slots.h"
#include "render/color/texture.h"

namespace tessera::render::TESSERA_ISA {

namespace {

Float opacity_of(const SceneTables& scene, const MaterialRecord& material, const Surface& surface,
                 Mask lanes) {
  if (!(material.flags & kHasOpacity)) return Float(1.0f);
  if (material.opacity.texture < 0) return Float(material.opacity.value);
  return clamp(eval_texture_scalar(scene.textures, material.opacity.texture, texture_point(surface), lanes),
               0.0f, 1.0f);
}

/// Light that the model of material `index` lets straight through.
Passing passing_of(const SceneTables& scene, std::int32_t index, const Surface& surface, Float cosine,
                   const Spectra& spectra, Mask lanes) {
  const MaterialRecord& material = scene.materials.materials[static_cast<std::size_t>(index)];
  BsdfParams params;
  load_constants(scene.materials, Int(index), &material, Int(material.flags), spectra, lanes, params);
  if (incomplete(params)) {
    complete_parameters(scene.materials, scene.textures, texture_point(surface), Int(index),
                        Int(static_cast<std::int32_t>(material.kind)), spectra, lanes, params);
  }
  return bsdf_model(material.kind)->passing(params, cosine);
}

/// The material of the side that light along `d` comes to.
Int seen_material(const SceneTables& scene, const Surface& surface, Vec3 d, Mask active) {
  constexpr int kStride = sizeof(MaterialRecord) / 4;
  const MaterialRecord* materials = scene.materials.materials.data();
  const Int record = surface.material * kStride;
  const Mask two_faced = active & ((gather(&materials->flags, record, active) & kHasBack) != 0);
  return select(two_faced & (dot(d, surface.ns) > 0.0f), gather(&materials->back, record, two_faced),
                surface.material);
}

}  // namespace

Float opacity_of(const SceneTables& scene, Int material, const Surface& surface, Mask active) {
  Float result(1.0f);
  for_each_distinct(material, active, [&](std::int32_t m, Mask lanes) {
    result = select(lanes,
                    opacity_of(scene, scene.materials.materials[static_cast<std::size_t>(m)], surface, lanes),
                    result);
  });
  return result;
}

Mask may_pass(const SceneTables& scene, Passenger who, Int shape, Mask active) {
  if (none(active)) return active;  // there may be no shapes, whose table cannot be read
  constexpr int kStride = sizeof(MaterialRecord) / 4;
  const ShapeRecord* shapes = scene.shapes.shapes.data();
  const MaterialRecord* materials = scene.materials.materials.data();
  const Int record = gather_member(shapes, &ShapeRecord::material, shape, active) * kStride;
  const Int flags = gather(&materials->flags, record, active);
  const Mask dark = active & (gather_member(shapes, &ShapeRecord::first_light, shape, active) < 0);
  std::int32_t passable = kHasBack;
  if (scene.paths_pass) passable |= kHasOpacity | kPassesStraight;
  if (who == Passenger::kLight && scene.straight_shadows) passable |= kAllDelta;
  return dark & ((flags & passable) != 0);
}

Passing passing_at(const SceneTables& scene, Passenger who, const Surface& surface, Vec3 d,
                   const Spectra& spectra, Mask active) {
  Passing result{Float(0.0f), Spectrum(1.0f)};
  for_each_distinct(seen_material(scene, surface, d, active), active, [&](std::int32_t m, Mask lanes) {
    const MaterialRecord& material = scene.materials.materials[static_cast<std::size_t>(m)];
    const bool straight = who == Passenger::kLight && scene.straight_shadows && is_clear_glass(material);
    if (!straight && !scene.paths_pass) return;
    const Float opacity = opacity_of(scene, material, surface, lanes);
    if (straight || (material.flags & kPassesStraight) != 0) {
      const Passing model = passing_of(scene, m, surface, abs(dot(surface.ns, d)), spectra, lanes);
      const Float through = model.probability, passes = 1.0f - opacity * (1.0f - through);
      // The open part of the surface has no tint.
      const Float tinted = opacity * through / max(passes, 1e-30f);
      result.probability = select(lanes, passes, result.probability);
      result.weight = select(lanes, lerp(tinted, Spectrum(1.0f), model.weight), result.weight);
    } else {
      result.probability = select(lanes, 1.0f - opacity, result.probability);
    }
  });
  return result;
}

Mask clear_glass_at(const SceneTables& scene, const Surface& surface, Vec3 d, Mask active) {
  Mask result = Mask::none();
  for_each_distinct(seen_material(scene, surface, d, active), active, [&](std::int32_t m, Mask lanes) {
    if (is_clear_glass(scene.materials.materials[static_cast<std::size_t>(m)])) result |= lanes;
  });
  return result;
}

Int medium_behind(const ShapeTable& table, const Surface& surface, Vec3 d, Int medium, Mask active) {
  if (none(active)) return medium;  // there may be no shapes, whose table cannot be read
  const ShapeRecord* shapes = table.shapes.data();
  const Mask border =
      active & ((gather_member(shapes, &ShapeRecord::flags, surface.shape, active) & kMediumBorder) != 0);
  if (none(border)) return medium;
  const Int interior = gather_member(shapes, &ShapeRecord::interior, surface.shape, border);
  const Int exterior = gather_member(shapes, &ShapeRecord::exterior, surface.shape, border);
  return select(border, select(dot(d, surface.ng) > 0.0f, exterior, interior), medium);
}

}  // namespace tessera::render::TESSERA_ISA
