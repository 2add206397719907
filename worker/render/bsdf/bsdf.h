// The interface of the BSDF models. One model a file; all models are stateless, so one object serves every
// material of its kind.
//
// Directions are unit vectors in the local shading frame (normal +z, tangents x and y along dp/du and
// across), pointing away from the surface. wo is where the path came from, wi where it goes on; both may lie
// below the surface. Radiance is transported (refraction scales by 1/eta^2).
#pragma once

#include "render/bsdf/material_table.h"
#include "render/color/spectrum.h"
#include "render/core/vec.h"

namespace tessera::render::TESSERA_ISA {

/// The slots of the material at each lane's hit point, textures already looked up.
struct BsdfParams {
  Spectrum spectra[kMaterialSpectra];
  Float scalars[kMaterialScalars];
  Int coat_table;
  const float* coat_tables;  // MaterialTable::coat_tables.data()
  Int flags;                 // MaterialFlags
  std::int32_t
      some_flags;  // all that some lane has, of whatever kind: models look at their variants only where set
  // With kUsesExtended
  Spectrum extended_spectra[kExtendedSpectra];
  Float extended[kExtendedScalars];

  /// Lanes that have `flag`.
  TESSERA_INLINE Mask with(std::int32_t flag) const { return (flags & flag) != 0; }
};

struct BsdfEval {
  Spectrum f_cos;  // f(wo, wi) |cos theta_i|, 1/sr; without delta lobes
  Float pdf;       // of sample() returning wi, solid angle; without delta lobes
};

struct BsdfSample {
  Vec3 wi;
  Spectrum weight;  // f |cos theta_i| / pdf, over all lobes that could give wi
  Float pdf;        // solid angle; for a delta lobe the probability of the lobe
  Float eta;        // for transmission: index of the side that wi is on over that of wo's side; else 1
  Mask valid;       // a direction was found; else the path ends
  Mask specular;    // from a delta lobe: not to be weighed against light sampling
  Mask transmission;
};

class Bsdf {
 public:
  virtual ~Bsdf() = default;
  /// Lanes that are not active may hold anything, and give anything.
  virtual BsdfEval eval(const BsdfParams& params, Vec3 wo, Vec3 wi, Mask active) const = 0;
  /// `u_lobe` and `u` are uniform in [0, 1).
  virtual BsdfSample sample(const BsdfParams& params, Vec3 wo, Float u_lobe, Vec2 u, Mask active) const = 0;
};

/// The model of a kind; null for kMix, which is not asked.
const Bsdf* bsdf_model(BsdfKind kind);

}  // namespace tessera::render::TESSERA_ISA
