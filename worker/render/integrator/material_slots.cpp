#include "render/integrator/material_slots.h"

#include "render/bsdf/hair.h"
#include "render/color/texture.h"

namespace tessera::render::TESSERA_ISA {

namespace {

constexpr int kStride = sizeof(MaterialRecord) / 4;
constexpr int kExtendedStride = sizeof(ExtendedRecord) / 4;

std::int32_t any_of(Int flags, Mask active) {
  alignas(64) std::int32_t lanes[kWidth];
  select_or_zero(active, flags).store(lanes);
  std::int32_t result = 0;
  for (const std::int32_t lane : lanes) result |= lane;
  return result;
}

/// A texture's value within the range of its slot: files hold whatever they hold. What is no number becomes 0.
TESSERA_INLINE Float bounded(Float value, float highest) {
  return select_or_zero(value > 0.0f, min(value, Float(highest)));
}

/// Overwrites the textured slots.
void look_up_textures(const SceneTables& scene, const TexturePoint& at, Int record, Mask textured, BsdfParams& params) {
  const MaterialRecord* records = scene.materials.materials.data();
  const auto* base = reinterpret_cast<const std::int32_t*>(records);
  const auto texture_at = [&](const std::int32_t& member) {
    return select(textured, gather(base + (&member - base), record * kStride, textured), Int(-1));
  };
  for (int i = 0; i < kMaterialSpectra; ++i) {
    const Int texture = texture_at(records->spectra[i].texture);
    for_each_distinct(texture, texture >= 0, [&](std::int32_t t, Mask lanes) {
      constexpr float kHighest = 1e6f;  // indices of conductors and absorption in hair are above 1
      Spectrum value = eval_texture(scene.textures, t, at, lanes);
      for (Float& c : value.c) c = bounded(c, kHighest);
      params.spectra[i] = select(lanes, value, params.spectra[i]);
    });
  }
  for (int i = 0; i < kMaterialScalars; ++i) {
    const Int texture = texture_at(records->scalars[i].texture);
    for_each_distinct(texture, texture >= 0, [&](std::int32_t t, Mask lanes) {
      Float value = eval_texture_scalar(scene.textures, t, at, lanes);
      // Scalars 0 and 1 are alphas, which pbrt's scenes give as roughness.
      if (i < 2) value = bounded(select(params.with(kRemapAlpha), safe_sqrt(value), value), 1.0f);
      params.scalars[i] = select(lanes, value, params.scalars[i]);
    });
  }
}

/// The slots of the ExtendedRecords of `lanes`.
void load_extended(const SceneTables& scene, const TexturePoint& at, Int record, Mask lanes, BsdfParams& params) {
  const ExtendedRecord* records = scene.materials.extended.data();
  const auto* base = reinterpret_cast<const float*>(records);
  const Int index = gather(&scene.materials.materials.data()->extended, record * kStride, lanes);
  const auto constant_at = [&](const float& member) {
    return gather(base + (&member - base), index * kExtendedStride, lanes);
  };
  for (int i = 0; i < kExtendedSpectra; ++i) {
    for (int c = 0; c < kSpectrumLanes; ++c)
      params.extended_spectra[i].c[c] = constant_at(records->spectra[i].value[c]);
  }
  for (int i = 0; i < kExtendedScalars; ++i) params.extended[i] = constant_at(records->scalars[i].value);

  const Mask textured = lanes & params.with(kHasTextures);
  if (none(textured)) return;
  for_each_distinct(index, textured, [&](std::int32_t e, Mask same) {
    const ExtendedRecord& extended = records[e];
    for (int i = 0; i < kExtendedSpectra; ++i) {
      const std::int32_t texture = extended.spectra[i].texture;
      if (texture < 0) continue;
      params.extended_spectra[i] =
          select(same, eval_texture(scene.textures, texture, at, same), params.extended_spectra[i]);
    }
    for (int i = 0; i < kExtendedScalars; ++i) {
      const std::int32_t texture = extended.scalars[i].texture;
      if (texture < 0) continue;
      Float value = eval_texture_scalar(scene.textures, texture, at, same);
      // The roughness of a coated conductor, as of scalars 0 and 1.
      if (i < 2) value = select(params.with(kRemapAlpha), safe_sqrt(value), value);
      // The last is diffuse transmission of principled sheets (principled_thin.h).
      value = bounded(value, i == kExtendedScalars - 1 ? 2.0f : 1.0f);
      params.extended[i] = select(same, value, params.extended[i]);
    }
  });
}

/// eta = 1 and the k that gives a conductor the reflectance looked up for it [pbrt-v4].
void reflectance_to_k(Mask lanes, BsdfParams& params) {
  for (int c = 0; c < kSpectrumLanes; ++c) {
    const Float r = clamp(params.spectra[1].c[c], 0.0f, 0.9999f);
    params.spectra[0].c[c] = select(lanes, Float(1.0f), params.spectra[0].c[c]);
    params.spectra[1].c[c] = select(lanes, 2.0f * sqrt(r / (1.0f - r)), params.spectra[1].c[c]);
  }
}

/// The index with which a dielectric has the normal reflectance 0.08 times Disney's "specular".
void specular_to_eta(Mask lanes, BsdfParams& params) {
  constexpr float kLeast = 1e-3f;  // without a change of index nothing is refracted
  const Float specular = clamp(params.scalars[2], kLeast, 1.0f);
  params.scalars[2] = select(lanes, 2.0f / (1.0f - sqrt(0.08f * specular)) - 1.0f, params.scalars[2]);
}

}  // namespace

void load_parameters(const SceneTables& scene, const Surface& surface, Int record, Mask active, MaterialPart& part) {
  const MaterialRecord* records = scene.materials.materials.data();
  const auto* base = reinterpret_cast<const float*>(records);
  const Int offset = record * kStride;
  BsdfParams& params = part.params;
  params.flags = part.flags;
  params.some_flags = any_of(part.flags, active);
  const auto constant_at = [&](const float& member) { return gather(base + (&member - base), offset, active); };

  // Only what some lane's model looks at.
  const auto some_use = [&](std::int32_t flag) { return (params.some_flags & flag) != 0; };
  for (int c = 0; c < kSpectrumLanes; ++c) params.spectra[0].c[c] = constant_at(records->spectra[0].value[c]);
  if (some_use(kUsesSecondSpectrum)) {
    for (int c = 0; c < kSpectrumLanes; ++c) params.spectra[1].c[c] = constant_at(records->spectra[1].value[c]);
  }
  if (some_use(kUsesAlphas)) {
    for (int i = 0; i < 2; ++i) params.scalars[i] = constant_at(records->scalars[i].value);
  }
  if (some_use(kUsesEta)) {
    params.scalars[2] = constant_at(records->scalars[2].value);
    params.coat_table = gather(&records->coat_table, offset, active);
  }
  params.coat_tables = scene.materials.coat_tables.data();

  if (some_use(kHasTextures)) {
    const Mask textured = active & params.with(kHasTextures);
    look_up_textures(scene, texture_point(surface), record, textured, params);
    if (some_use(kConductorReflectance)) reflectance_to_k(textured & params.with(kConductorReflectance), params);
    if (some_use(kEtaFromSpecular)) specular_to_eta(textured & params.with(kEtaFromSpecular), params);
  }
  if (!some_use(kUsesExtended)) return;
  load_extended(scene, texture_point(surface), record, active & params.with(kUsesExtended), params);
  const Mask hair = active & (part.kind == static_cast<std::int32_t>(BsdfKind::kHair));
  if (any(hair)) prepare_hair(surface.uv.y, hair, params);
}

}  // namespace tessera::render::TESSERA_ISA
