// Path tracing that ends where a cache of irradiance knows the rest [Ward, Rubinstein & Clear 1988]: at
// surfaces that scatter light evenly, it interpolates what the phases have computed (phase.h); at those with
// a wide gloss, incoming radiance [Krivanek, Gautron, Pattanaik & Bouatouch 2005]. Lamps are sampled there as
// path tracing does; mirrors, glass and narrow gloss are followed; where no record reaches, so is the path,
// to the next such surface.
#pragma once

#include "render/textbook/irradiance_cache/cache.h"
#include "render/transport/path/wavefront.h"

namespace tessera::render::TESSERA_ISA {

/// Lanes whose light a cache can hold.
struct Cacheable {
  Mask even;    // light that is the same towards all directions: irradiance
  Mask glossy;  // incoming radiance in spherical harmonics

  Mask any() const { return even | glossy; }
};
/// Those of `hit`, but for the last events of paths.
Cacheable cacheable(const SceneTables& scene, const Vertex& v, Mask hit, int depth);

/// Alpha of facets from which on spherical harmonics of so many bands keep a lobe: the first band left out
/// then has exp(-(bands alpha)^2) = 2 % of the light's own waves [Ramamoorthi & Hanrahan 2001, section 5.2].
constexpr float least_alpha_of(int bands) { return 2 / static_cast<float>(bands); }

/// The normal of the hemisphere that lights the vertex.
TESSERA_INLINE Vec3 cached_normal(const Vertex& v) { return face_forward(v.at.frame.z, v.wo); }

class IrradianceCached : public Wavefront, protected PathObserver {
 public:
  /// Without a cache in the context, it is path tracing.
  explicit IrradianceCached(const IntegratorContext& context)
      : IrradianceCached(context, static_cast<const IrradianceCache*>(context.prepared),
                         context.scene.irradiance_cache.view) {}

 protected:
  /// `cache` may be null; its records are marked in the picture, if they are `shown`.
  IrradianceCached(const IntegratorContext& context, const IrradianceCache* cache, bool shown)
      : Wavefront(context), cache_(cache), shown_(shown) {
    add(*this);
  }

  void met(Encounter& e) override;

 private:
  Mask settle_even(const WidePath& path, const Vertex& v, Mask wanted);
  Mask settle_glossy(const WidePath& path, const Vertex& v, Mask wanted, int depth);
  Lobe lobe_of(const WidePath& path, const Vertex& v, Mask lanes, int depth) const;

  const IrradianceCache* const cache_;
  const bool shown_;
};

}  // namespace tessera::render::TESSERA_ISA
