// Materials as the kernels read them: plain records, filled by build/, the same for every ISA.
#pragma once

#include <cstdint>
#include <vector>

namespace tessera::render {

enum class BsdfKind : std::int32_t {
  kInterface,  // nothing there: paths go straight on
  kDiffuse,
  kConductor,
  kDielectric,
  kThinDielectric,
  kCoatedDiffuse,
  kDiffuseTransmission,
  kMix,  // resolved to one of its parts before any BSDF is asked
  kCount
};

/// Bits of MaterialRecord::flags.
enum MaterialFlags : std::int32_t {
  kAllDelta = 1,               // no light can be sampled towards it
  kHasTextures = 2,            // some slot is textured
  kHasBump = 4,                // bump_texture or normal_texture is set
  kAnisotropic = 8,            // needs a shading frame along dp/du
  kRemapAlpha = 16,            // textured alphas are pbrt roughnesses: alpha = sqrt(value)
  kConductorReflectance = 32,  // spectra[1] is a texture of the reflectance at normal incidence, not k
  // What the model looks at besides spectra[0]; the rest is not even fetched.
  kUsesSecondSpectrum = 64,  // spectra[1]
  kUsesAlphas = 128,         // scalars[0] and [1]
  kUsesEta = 256,            // scalars[2] and coat_table
};

inline constexpr int kMaterialSpectra = 2;
inline constexpr int kMaterialScalars = 3;

/// A constant, or a texture of the TextureTable (then the constant is ignored).
struct SpectrumSlot {
  float value[3] = {0, 0, 0};
  std::int32_t texture = -1;
};
struct ScalarSlot {
  float value = 0;
  std::int32_t texture = -1;
};

/// What each slot means is said by the model's file (bsdf/diffuse.h and so on).
struct MaterialRecord {
  BsdfKind kind = BsdfKind::kDiffuse;
  std::int32_t flags = 0;
  SpectrumSlot spectra[kMaterialSpectra];
  ScalarSlot scalars[kMaterialScalars];
  std::int32_t bump_texture = -1;
  std::int32_t normal_texture = -1;
  std::int32_t mix_a = -1, mix_b = -1;  // materials; scalars[0] is the probability of b
  // Offset into MaterialTable::coat_tables (kCoatedDiffuse; from append_coat_table()), else -1.
  std::int32_t coat_table = -1;
  std::int32_t padding[11] = {};
};
static_assert(sizeof(MaterialRecord) == 128);

struct MaterialTable {
  std::vector<MaterialRecord> materials;
  // Transmittance and internal reflectance of rough dielectric coats; layout in bsdf/coat_table.h.
  std::vector<float> coat_tables;
};

}  // namespace tessera::render
