// From a surface point to a BSDF with its parameters: sides and mixes resolved, textures looked up, normals
// bent. Shared by all integrators.
#pragma once

#include "render/bsdf/bsdf.h"
#include "render/bsdf/lambertian.h"
#include "render/color/spectra.h"
#include "render/integrator/scene_tables.h"
#include "render/shape/surface.h"

namespace tessera::render::TESSERA_ISA {

/// One material at 16 surface points.
struct MaterialPart {
  Int kind;      // BsdfKind
  Int material;  // number of the material; of a mix, that of the mix; from behind, that of the material there
  Int flags;     // MaterialFlags
  Int traits;    // BsdfTraits
  BsdfParams params;
  Frame frame;  // shading frame, z on the side of the geometric normal before bump and normal maps
  // With kHasBump only
  Vec3 ns;            // shading normal before those
  Float bump_alpha2;  // squared roughness of a surface that is tilted as much as the bent normal
  // All lanes that were asked for are Lambertian, from both sides and with normals that are not bent.
  bool lambertian = false;
};

/// Matter that scatters light at 16 surface points. `flags` are those of the whole, `traits` of the first
/// part, which in lanes that have kMixed counts 1 - amount, and `second` the rest.
struct Interaction : MaterialPart {
  Float amount;
  MaterialPart second;
};

/// Fills `at`. `wo` is where the path came from; `u` picks the parts of mixes of mixes.
void interact(const SceneTables& scene, const Surface& surface, Vec3 wo, Float u, const Spectra& spectra,
              Mask active, Interaction& at);

/// Where light is scattered back to the side of wo only.
TESSERA_INLINE Mask reflects_only(const Interaction& at) {
  return and_not((at.traits & kReflectsOnly) != 0, (at.flags & kMixed) != 0);
}

/// Lanes whose density of samples is only an estimate.
TESSERA_INLINE Mask estimates_density(const Interaction& at, Mask active) {
  const Mask second = active & ((at.flags & kMixed) != 0);
  Mask result = active & ((at.traits & kEstimatedDensity) != 0);
  if (any(second)) result |= second & ((at.second.traits & kEstimatedDensity) != 0);
  return result;
}

/// eval_bsdf() of lanes of any kind.
BsdfEval eval_any_bsdf(const Interaction& at, Vec3 wo, Vec3 wi, Mask active, Transport transport);
/// f |cos| and pdf in render space.
TESSERA_INLINE BsdfEval eval_bsdf(const Interaction& at, Vec3 wo, Vec3 wi, Mask active,
                                  Transport transport = Transport::kRadiance) {
  if (!at.lambertian) return eval_any_bsdf(at, wo, wi, active, transport);
  const Vec3& n = at.frame.z;
  return eval_lambertian(at.params.spectra[slot::kReflectance], dot(wo, n), dot(wi, n), active);
}
/// One part of a mix is chosen; pdf and weight are of both, unless it was a delta lobe.
BsdfSample sample_bsdf(const Interaction& at, Vec3 wo, Float u_lobe, Vec2 u, Mask active,
                       Transport transport = Transport::kRadiance);

/// The part of eval_bsdf() that is of diffuse lobes, from 0 to 1; the rest is of glossy ones.
Float diffuse_share(const Interaction& at, Vec3 wo, Vec3 wi, Mask active);

/// Bsdf::least_alpha() of a part; of models that do not reflect only, 0.
Float least_alpha(const MaterialPart& part, Mask active);

/// An estimate of the surface's colour for the albedo AOV.
Spectrum albedo_of(const Interaction& at, Mask active);

}  // namespace tessera::render::TESSERA_ISA
