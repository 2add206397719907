// Materials as the kernels read them: plain records, filled by scene/, the same for every ISA.
#pragma once

#include <cstdint>
#include <vector>

#include "render/color/bands.h"

namespace tessera::render {

/// The models of bsdf/models.cpp, in its order; kinds from kCount on are those that add_bsdf() gives.
enum class BsdfKind : std::int32_t {
  kInterface,  // nothing there: paths go straight on
  kDiffuse,
  kConductor,
  kDielectric,
  kThinDielectric,
  kCoatedDiffuse,
  kDiffuseTransmission,
  kPlastic,
  kCoatedConductor,
  kHair,
  kPrincipled,
  kPrincipledThin,
  kPhong,
  kGltf,
  kMix,  // resolved into its two parts before any BSDF is asked
  kCount
};

/// The kind of a surface that is not there.
inline constexpr BsdfKind kNoSurface = BsdfKind::kInterface;

/// Bits of MaterialRecord::flags.
enum MaterialFlags : std::int32_t {
  kAllDelta = 1,     // no light can be sampled towards it
  kHasTextures = 2,  // some slot is textured
  kHasBump = 4,      // bump_texture or normal_texture is set
  kAnisotropic = 8,  // needs a shading frame along dp/du
  kRemapAlpha = 16,  // textured alphas are pbrt roughnesses: alpha = sqrt(value)
  kPrepared = 32,    // Bsdf::prepare() completes the slots once textures are looked up
  // Slots that the model reads besides spectra[0]; the rest is not even fetched.
  kUsesSecondSpectrum = 64,  // spectra[1]
  kUsesAlphas = 128,         // scalars[0] and [1]
  kUsesEta = 256,            // scalars[2] and coat_table
  kUsesExtended = 512,       // the ExtendedRecord
  // Variants of the models.
  kBeckmann = 1 << 10,          // microfacets of Beckmann's distribution instead of GGX
  kSeparableMasking = 1 << 11,  // masking and shadowing multiply instead of being correlated by height
  kTinted = 1 << 12,            // the tints among the slots are not all 1
  kNonlinear = 1 << 13,         // PlasticMaterial::nonlinear
  kHasInside = 1 << 14,  // kPrincipled, kGltf: light gets through, so that below the surface is not as above
  kUsesFurther = 1 << 15,      // with kUsesExtended: its further slots
  kHairReflectance = 1 << 16,  // kHair: spectra[0] is the colour of much hair, not its absorption
  // The two sides.
  kOneSided = 1 << 17,  // black when seen from behind
  kHasBack = 1 << 18,   // MaterialRecord::back is what is seen from behind
  // For the integrator alone.
  kHasOpacity = 1 << 19,  // `opacity` may be below 1
  kPassesStraight =
      1 << 20,       // Bsdf::passing(): what goes straight through is not scattered in volumetric scenes
  kMixed = 1 << 21,  // mix_a and mix_b; of an Interaction: it has a second part
  kBendsSoftly = 1 << 22,  // with kHasBump: Material::bends_softly
  // Further variants of the models.
  kBlinn = 1 << 26,       // kPhong: the lobe is of the half vector
  kMirrorLobe = 1 << 27,  // kPhong: the lobe is a mirror
  kBalanced = 1 << 23,    // Roughness::multiple_scattering; coat_table is of bsdf/tables/balance_table.h
  // Flags that hold for all materials of a model (Bsdf::traits): put beside a material's own flags when it is
  // loaded.
  kReflectsOnly = 1 << 24,  // light is scattered back to the side of wo alone
  kLambertian = 1 << 28,    // light is scattered back evenly: f is the same for all directions of that side
  kAllDiffuse = 1 << 30,    // all lobes but delta ones are diffuse, for layers
  kSomeDiffuse = 1 << 29,   // some are: Bsdf::diffuse_share() tells
  kEstimatedDensity = 1 << 25,  // `pdf` is not that of sample(): good for weighing, not for dividing f_cos by
};

inline constexpr int kMaterialSpectra = 2;
inline constexpr int kMaterialScalars = 3;
inline constexpr int kExtendedSpectra = 2;
inline constexpr int kExtendedScalars = 9;
inline constexpr int kFurtherSpectra = 1;
inline constexpr int kFurtherScalars = 4;

/// A constant, or a texture of the TextureTable (then the constant is ignored).
struct SpectrumSlot {
  float value[kBands] = {0, 0, 0};
  std::int32_t texture = -1;
};
struct ScalarSlot {
  float value = 0;
  std::int32_t texture = -1;
};

/// Slots are named in bsdf/slots.h and at the head of the model's file (bsdf/model/diffuse.cpp and so on).
struct MaterialRecord {
  BsdfKind kind = BsdfKind::kDiffuse;
  std::int32_t flags = 0;
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
  std::int32_t padding[5] = {};
};
static_assert(sizeof(MaterialRecord) == 128);

/// More slots, for the few models that need them.
struct ExtendedRecord {
  SpectrumSlot spectra[kExtendedSpectra];
  ScalarSlot scalars[kExtendedScalars];
  SpectrumSlot further_spectra[kFurtherSpectra];
  ScalarSlot further[kFurtherScalars];
};

/// A smooth dielectric or a thin sheet of one, without holes.
inline bool is_clear_glass(const MaterialRecord& material) {
  return (material.kind == BsdfKind::kDielectric || material.kind == BsdfKind::kThinDielectric) &&
         (material.flags & (kAllDelta | kHasOpacity)) == kAllDelta;
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
