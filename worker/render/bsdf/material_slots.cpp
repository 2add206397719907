#include "render/bsdf/material_slots.h"

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

/// A texture's value within the range of its slot: files hold whatever they hold. What is no number becomes
/// 0.
TESSERA_INLINE Float bounded(Float value, float highest) {
  return select_or_zero(value > 0.0f, min(value, Float(highest)));
}

/// Overwrites the textured slots.
void look_up_textures(const MaterialTable& materials, const TextureTable& textures, const TexturePoint& at,
                      Int record, const Spectra& spectra, Mask textured, BsdfParams& params) {
  for_each_distinct(record, textured, [&](std::int32_t m, Mask lanes) {
    const MaterialRecord& material = materials.materials[static_cast<std::size_t>(m)];
    for (int i = 0; i < kMaterialSpectra; ++i) {
      constexpr float kHighest = 1e6f;  // indices of conductors and absorption in hair are above 1
      if (material.spectra[i].texture < 0) continue;
      Color value = eval_texture(textures, material.spectra[i].texture, at, lanes);
      for (Float& c : value.c) c = bounded(c, kHighest);
      params.spectra[i] = select(lanes, spectra.factor(value, lanes), params.spectra[i]);
#ifdef TESSERA_SPECTRAL
      if (i == 0) params.luminance = select(lanes, luminance(value), params.luminance);
#endif
    }
    for (int i = 0; i < kMaterialScalars; ++i) {
      if (material.scalars[i].texture < 0) continue;
      Float value = eval_texture_scalar(textures, material.scalars[i].texture, at, lanes);
      // pbrt's scenes give alphas as roughness.
      if (i <= slot::kAlphaY)
        value = bounded((material.flags & kRemapAlpha) != 0 ? safe_sqrt(value) : value, 1.0f);
      params.scalars[i] = select(lanes, value, params.scalars[i]);
    }
  });
}

/// The constant slots that some lane's model looks at; the rest is not even fetched.
void load_constants(const MaterialTable& materials, Int record, const Spectra& spectra, Mask active,
                    BsdfParams& params) {
  const MaterialRecord* records = materials.materials.data();
  const auto* base = reinterpret_cast<const float*>(records);
  const auto row_at = [&](const float& first) {
    return gather4(base + (&first - base), record * kStride, active);
  };
  const auto curve_at = [&](const std::int32_t* first) {
    return kSpectral ? gather(first, record * kStride, active) : Int(-1);
  };
  const auto spectrum_at = [&](const SpectrumSlot& slot) {
    const Float4 row = row_at(slot.value[0]);
    return spectra.constant(color_of([&](int band) { return row.c[band]; }), curve_at(&slot.curve), active);
  };
  const auto some_use = [&](std::int32_t flag) { return (params.some_flags & flag) != 0; };
  params.variants = Int(0);
  params.some_variants = 0;
  if (some_use(kUsesVariants)) {
    params.variants = gather(&records->variants, record * kStride, active);
    params.some_variants = any_of(params.variants, active);
  }
  params.spectra[0] = spectrum_at(records->spectra[0]);
#ifdef TESSERA_SPECTRAL
  params.luminance = gather(&records->luminance, record * kStride, active);
#endif
  if (some_use(kUsesSecondSpectrum)) params.spectra[1] = spectrum_at(records->spectra[1]);
  if (some_use(kUsesAlphas)) {
    static_assert(sizeof(ScalarSlot) == 8);
    const Float4 row = row_at(records->scalars[slot::kAlphaX].value);
    params.scalars[slot::kAlphaX] = row.c[0], params.scalars[slot::kAlphaY] = row.c[2];
  }
  if (some_use(kUsesEta)) {
    params.scalars[slot::kEta] = gather(&records->scalars[slot::kEta].value, record * kStride, active);
    params.coat_table = gather(&records->coat_table, record * kStride, active);
  }
}

/// The same for lanes that all have one material.
void load_constants(const MaterialRecord& material, const Spectra& spectra, Mask active, BsdfParams& params) {
  params.variants = Int(material.variants);
  params.some_variants = material.variants;
  for (int i = 0; i < kMaterialSpectra; ++i) {
    const SpectrumSlot& slot = material.spectra[i];
    params.spectra[i] = spectra.constant(color_of(slot.value), Int(slot.curve), active);
  }
  for (int i = 0; i < kMaterialScalars; ++i) params.scalars[i] = Float(material.scalars[i].value);
#ifdef TESSERA_SPECTRAL
  params.luminance = Float(material.luminance);
#endif
  params.coat_table = Int(material.coat_table);
}

#ifdef TESSERA_SPECTRAL
/// The indices of refraction that vary.
void load_etas(const MaterialTable& materials, Int record, const Spectra& spectra, Mask active,
               BsdfParams& params) {
  const Mask vary = active & params.with(kDisperses);
  const Int curve = gather(&materials.materials.data()->eta_curve, record * kStride, vary);
  const Spectrum etas = spectra.curve(curve, vary);
  params.etas = select(vary, etas, Spectrum(params.scalars[slot::kEta]));
  params.scalars[slot::kEta] = params.etas.c[0];
}
#endif

void look_up_further(const ExtendedRecord& extended, const TextureTable& textures, const TexturePoint& at,
                     Mask lanes, BsdfParams& params) {
  constexpr float kHighest = 1e6f;  // nanometres of a film
  for (int i = 0; i < kFurtherColors; ++i) {
    const std::int32_t texture = extended.further_colors[i].texture;
    if (texture < 0) continue;
    params.further_colors[i] =
        select(lanes, eval_texture(textures, texture, at, lanes), params.further_colors[i]);
  }
  for (int i = 0; i < kFurtherScalars; ++i) {
    const std::int32_t texture = extended.further[i].texture;
    if (texture < 0) continue;
    const Float value = bounded(eval_texture_scalar(textures, texture, at, lanes), kHighest);
    params.further[i] = select(lanes, value, params.further[i]);
  }
}

/// The slots of the ExtendedRecords of `lanes`.
void load_extended(const MaterialTable& materials, const TextureTable& textures, const TexturePoint& at,
                   Int record, const Spectra& spectra, Mask lanes, BsdfParams& params) {
  const ExtendedRecord* records = materials.extended.data();
  const auto* base = reinterpret_cast<const float*>(records);
  const Int index = gather(&materials.materials.data()->extended, record * kStride, lanes);
  const auto constant_at = [&](const float& member) {
    return gather(base + (&member - base), index * kExtendedStride, lanes);
  };
  for (int i = 0; i < kExtendedSpectra; ++i) {
    const SpectrumSlot& slot = records->spectra[i];
    const Int curve = kSpectral ? gather(&slot.curve, index * kExtendedStride, lanes) : Int(-1);
    params.extended_spectra[i] =
        spectra.constant(color_of([&](int band) { return constant_at(slot.value[band]); }), curve, lanes);
  }
  for (int i = 0; i < kExtendedScalars; ++i) params.extended[i] = constant_at(records->scalars[i].value);
  const bool further = (params.some_flags & kUsesFurther) != 0;
  if (further) {
    for (int i = 0; i < kFurtherColors; ++i) {
      params.further_colors[i] =
          color_of([&](int band) { return constant_at(records->further_colors[i].value[band]); });
    }
    for (int i = 0; i < kFurtherScalars; ++i) params.further[i] = constant_at(records->further[i].value);
  }

  const Mask textured = lanes & params.with(kHasTextures);
  if (none(textured)) return;
  for_each_distinct(index, textured, [&](std::int32_t e, Mask same) {
    const ExtendedRecord& extended = records[e];
    for (int i = 0; i < kExtendedSpectra; ++i) {
      const std::int32_t texture = extended.spectra[i].texture;
      if (texture < 0) continue;
      params.extended_spectra[i] = select(
          same, spectra.factor(eval_texture(textures, texture, at, same), same), params.extended_spectra[i]);
    }
    for (int i = 0; i < kExtendedScalars; ++i) {
      const std::int32_t texture = extended.scalars[i].texture;
      if (texture < 0) continue;
      Float value = eval_texture_scalar(textures, texture, at, same);
      // The roughness of a coated conductor's base, like that of its coat.
      if (i <= slot::kBaseAlphaY) value = select(params.with(kRemapAlpha), safe_sqrt(value), value);
      value = bounded(value, i == slot::kDiffTrans ? 2.0f : 1.0f);
      params.extended[i] = select(same, value, params.extended[i]);
    }
    if (further) look_up_further(extended, textures, at, same, params);
  });
}

}  // namespace

void load_constants(const MaterialTable& materials, Int record, const MaterialRecord* common, Int flags,
                    const Spectra& spectra, Mask active, BsdfParams& params) {
  params.flags = flags;
#ifdef TESSERA_SPECTRAL
  params.wavelengths = spectra.wavelengths();
#endif
  params.some_flags = any_of(flags, active);
  if (common) {
    load_constants(*common, spectra, active, params);
  } else {
    load_constants(materials, record, spectra, active, params);
  }
#ifdef TESSERA_SPECTRAL
  if ((params.some_flags & kDisperses) != 0) load_etas(materials, record, spectra, active, params);
#endif
  params.coat_tables = materials.coat_tables.data();
  params.film_table = materials.film_table.data();
}

void complete_parameters(const MaterialTable& materials, const TextureTable& textures, const TexturePoint& at,
                         Int record, Int kind, const Spectra& spectra, Mask active, BsdfParams& params) {
  const auto some_use = [&](std::int32_t flag) { return (params.some_flags & flag) != 0; };
  if (some_use(kHasTextures)) {
    look_up_textures(materials, textures, at, record, spectra, active & params.with(kHasTextures), params);
  }
  if (some_use(kUsesExtended)) {
    load_extended(materials, textures, at, record, spectra, active & params.with(kUsesExtended), params);
  }
  if (!some_use(kPrepared)) return;
  for_each_distinct(kind, active & params.with(kPrepared), [&](std::int32_t k, Mask lanes) {
    bsdf_model(static_cast<BsdfKind>(k))->prepare(at, lanes, params);
  });
}

}  // namespace tessera::render::TESSERA_ISA
