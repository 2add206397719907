// Path tracing that ends where a cache of irradiance knows the rest [Ward, Rubinstein & Clear 1988]: at
// surfaces that scatter light evenly, it interpolates what the phases have computed (phase.h). Lamps are
// sampled there as path tracing does; mirrors, glass and gloss are followed; where no record reaches, so is
// the path, to the next such surface.
#pragma once

#include "render/integrator/irradiance_cache/cache.h"
#include "render/integrator/path/wavefront.h"

namespace tessera::render::TESSERA_ISA {

/// Lanes of `hit` whose light a cache can hold: the same towards all directions, and not the last of a path.
Mask is_cacheable(const SceneTables& scene, const Vertex& v, Mask hit, int depth);

/// The normal of the hemisphere that lights the vertex.
TESSERA_INLINE Vec3 cached_normal(const Vertex& v) { return face_forward(v.at.frame.z, v.wo); }

class IrradianceCached : public Wavefront {
 public:
  /// Without a cache in the context, it is path tracing.
  explicit IrradianceCached(const IntegratorContext& context)
      : IrradianceCached(context, static_cast<const IrradianceCache*>(context.prepared),
                         context.scene.irradiance_cache.view) {}

 protected:
  /// `cache` may be null; its records are marked in the picture, if they are `shown`.
  IrradianceCached(const IntegratorContext& context, const IrradianceCache* cache, bool shown)
      : Wavefront(context), cache_(cache), shown_(shown) {}

  Mask settle(WidePath& path, const Vertex& v, Float t, Mask hit, int depth) override;

 private:
  const IrradianceCache* const cache_;
  const bool shown_;
};

}  // namespace tessera::render::TESSERA_ISA
