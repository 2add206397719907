// Materials as the kernels read them: plain records, filled by scene/, the same for every ISA.
#pragma once

#include <cstdint>
#include <vector>

#include "render/bsdf/kinds.h"
#include "render/color/bands.h"

namespace tessera::render {

/// Bits of MaterialRecord::flags: what a material is, for all who meet it. What holds for all materials of a
/// model is apart (BsdfTraits), and so is what a model alone asks for (bsdf/kinds.h).
enum MaterialFlags : std::int32_t {
  kAllDelta = 1 << 0,     // Light cannot be sampled towards it.
  kHasTextures = 1 << 1,  // some slot is textured
  kHasBump = 1 << 2,      // bump_texture or normal_texture is set
  kAnisotropic = 1 << 3,  // needs a shading frame along dp/du
  kRemapAlpha = 1 << 4,   // textured alphas are pbrt roughnesses: alpha = sqrt(value)
  kPrepared = 1 << 5,     // Bsdf::prepare() completes the slots once textures are looked up
  // Parts of the record that the model reads besides spectra[0]; the rest is not even fetched.
  kUsesSecondSpectrum = 1 << 6,  // spectra[1]
  kUsesAlphas = 1 << 7,          // scalars[0] and [1]
  kUsesEta = 1 << 8,             // scalars[2] and coat_table
  kUsesExtended = 1 << 9,        // the ExtendedRecord
  kUsesFurther = 1 << 10,        // further slots, with kUsesExtended
  kUsesVariants = 1 << 11,       // variants is not 0
  // The two sides.
  kHasInside = 1 << 12,  // light gets through, so that below the surface is not as above
  kOneSided = 1 << 13,   // black when seen from behind
  kHasBack = 1 << 14,    // MaterialRecord::back is what is seen from behind
  // For the integrator alone.
  kHasOpacity = 1 << 15,  // `opacity` may be below 1
  kPassesStraight =
      1 << 16,       // Bsdf::passing(): what goes straight through is not scattered in volumetric scenes
  kMixed = 1 << 17,  // mix_a and mix_b; of an Interaction: it has a second part
  kBendsSoftly = 1 << 18,  // Material::bends_softly, with kHasBump
  // For those that look at a scene as a whole, before it is rendered.
  kHasDeltaLobe = 1 << 19,  // a mirror, clear glass, or a clear coat over something else
  kTransmits = 1 << 20,     // scatters light to the other side, whatever its parameters are
  kSheet = 1 << 21,         // a sheet without thickness: Material::one_sided says nothing of it
  kDiffuseBase = 1 << 22,   // spectra[slot::kReflectance] is of a diffuse base
  // Jobs of wavelengths only: the index of refraction varies as MaterialRecord::eta_curve does.
  kDisperses = 1 << 23
};

/// Bits of Bsdf::traits: what holds for all materials of a model.
enum BsdfTraits : std::int32_t {
  kReflectsOnly = 1 << 0,  // light is scattered back to the side of wo alone
  kLambertian = 1 << 1,    // light is scattered back evenly: f is the same for all directions of that side
  kAllDiffuse = 1 << 2,    // All lobes but delta ones are diffuse, for layers.
  kSomeDiffuse = 1 << 3,   // some are: Bsdf::diffuse_share() tells
  kEstimatedDensity = 1 << 4,  // `pdf` is not that of sample(): good for weighing, not for dividing f_cos by
  kRefracts = 1 << 5           // what gets through changes its direction, and has an inside behind it
};

inline constexpr int kMaterialSpectra = 2;
inline constexpr int kMaterialScalars = 3;
inline constexpr int kExtendedSpectra = 2;
inline constexpr int kExtendedScalars = 9;
inline constexpr int kFurtherColors = 1;
inline constexpr int kFurtherScalars = 4;

/// A constant, or a texture of the TextureTable (then the constant is ignored). In jobs of wavelengths, the
/// constant is the coefficients of a sigmoid, or it is a curve.
struct SpectrumSlot {
  float value[kBands] = {0, 0, 0};
  std::int32_t texture = -1;  // -1: the constant
  std::int32_t curve = -1;    // jobs of wavelengths only: in SpectralTables::curves, in place of the constant
};
struct ScalarSlot {
  float value = 0;
  std::int32_t texture = -1;
};

/// Slots are named in bsdf/kinds.h and at the head of the model's file (bsdf/model/diffuse.cpp and so on).
struct MaterialRecord {
  BsdfKind kind = BsdfKind::kDiffuse;
  std::int32_t flags = 0;  // MaterialFlags
  SpectrumSlot spectra[kMaterialSpectra];
  ScalarSlot scalars[kMaterialScalars];
  ScalarSlot opacity{1, -1};
  std::int32_t bump_texture = -1;
  std::int32_t normal_texture = -1;
  std::int32_t mix_a = -1, mix_b = -1;  // materials, with kMixed; slot::kMixAmount: the probability of b
  // Offset into MaterialTable::coat_tables (kCoatedDiffuse, kPlastic, with kBalanced), else -1.
  std::int32_t coat_table = -1;
  std::int32_t extended = 0;               // index in MaterialTable::extended, with kUsesExtended
  std::int32_t back = -1;                  // material, with kHasBack
  float bump_step = 0;                     // step in u and v over which the bump texture is differentiated
  std::int32_t upper_normal_texture = -1;  // normal map of the layer above the base, with kUsesFurther
  std::int32_t variants = 0;               // bits of the kind (bsdf/kinds.h), with kUsesVariants
  float luminance = 0;  // jobs of wavelengths only: of the colour of spectra[0] in daylight
  // Jobs of wavelengths only: the curve of slot::kEta, with kDisperses, else -1.
  std::int32_t eta_curve = -1;
};
static_assert(sizeof(MaterialRecord) == 128);

/// More slots, for the few models that need them.
struct ExtendedRecord {
  SpectrumSlot spectra[kExtendedSpectra];
  ScalarSlot scalars[kExtendedScalars];
  SpectrumSlot further_colors[kFurtherColors];
  ScalarSlot further[kFurtherScalars];
};

/// Gives the material variants of its kind.
inline void set_variants(MaterialRecord& material, std::int32_t variants) {
  material.variants |= variants;
  if (variants != 0) material.flags |= kUsesVariants;
}

/// A smooth dielectric or a thin sheet of one, without holes.
inline bool is_clear_glass(const MaterialRecord& material) {
  constexpr std::int32_t kClear = kAllDelta | kTransmits;
  return (material.flags & (kClear | kHasOpacity)) == kClear;
}

struct MaterialTable {
  std::vector<MaterialRecord> materials;
  std::vector<ExtendedRecord> extended;
  // Energies of rough boundaries; layouts in bsdf/tables: coat_table.h, plastic_table.h, balance_table.h,
  // layer_table.h.
  std::vector<float> coat_tables;
  std::vector<float> film_table;           // bsdf/tables/film_table.h; empty where nothing is iridescent
  std::vector<std::int32_t> coat_offsets;  // offsets of the tables of bsdf/tables/coat_table.h
};

}  // namespace tessera::render
