// Radiance caching: light at glossy surfaces from records of what comes to points of them [Krivanek, Gautron,
// Pattanaik & Bouatouch 2005].
#pragma once

#include "render/color/spectrum.h"
#include "render/textbook/irradiance_cache/harmonics.h"
#include "render/textbook/irradiance_cache/record_site.h"
#include "render/textbook/irradiance_cache/record_tree.h"

namespace tessera::render::TESSERA_ISA {

/// How 16 points scatter light towards the eye: directions with the light's weights, drawn from the BSDF. The
/// mean of a function of direction, times the weights, is the integral of its product with the BSDF and the
/// cosine; so any model has a lobe, and nothing of it need be tabulated beforehand.
struct Lobe {
  static constexpr int kDirections = 4;
  Vec3 wi[kDirections];          // render space
  Spectrum weight[kDirections];  // 0 where no direction was found; over kDirections
};

class GlossyCache {
 public:
  /// Records are used where their error is below `error`.
  GlossyCache(GlossyRecords records, float error);

  struct Light {
    Spectrum value;  // radiance
    Mask found;
  };
  /// The light that the lobe's surface scatters to the eye at points `p` with normals `n`, where some record
  /// reaches them: the mean over these, with weights as of IrradianceCache, of the products of their
  /// harmonics, extrapolated by their gradients, with those of the lobe. Each record's are in its own frame,
  /// into which the lobe is turned: nothing has to be rotated. A lane's bits do not depend on the others.
  Light look_up(Vec3 p, Vec3 n, const Lobe& lobe, Mask active) const;

  const RecordTree& tree() const { return tree_; }
  /// In the order of the tree.
  const std::vector<RecordSite>& sites() const { return records_.sites; }

 private:
  class Projection;

  float error_;
  RecordTree tree_;
  GlossyRecords records_;
  Harmonics harmonics_;
};

}  // namespace tessera::render::TESSERA_ISA
