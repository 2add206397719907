// All records of a picture, to be read by any number of threads.
#pragma once

#include <vector>

#include "render/color/spectrum.h"
#include "render/film/prepared.h"
#include "render/textbook/irradiance_cache/glossy_cache.h"
#include "render/textbook/irradiance_cache/record_site.h"
#include "render/textbook/irradiance_cache/record_tree.h"

namespace tessera::render::TESSERA_ISA {

/// Irradiance at 16 points, where some record reaches them.
struct Irradiance {
  Spectrum value;
  Mask found;
};

class IrradianceCache final : public Prepared {
 public:
  /// Records are used where their error is below `error`; those of glossy surfaces may be left out.
  IrradianceCache(std::vector<IrradianceRecord> records, float error, GlossyRecords glossy = {});

  /// Interpolates at points `p` with normals `n`: the mean of the records that reach them, each extrapolated
  /// by its gradients and weighted by how far it is within its error [Ward & Heckbert 1992; the weights are
  /// those of Tabellion & Lamorlette 2004, which fall to zero]. A lane's bits do not depend on the others.
  Irradiance look_up(Vec3 p, Vec3 n, Mask active) const;
  /// Lanes that some record reaches with an error below `error`, which is not above that of the cache; for
  /// lanes of `glossy` those of glossy surfaces count.
  Mask covers(Vec3 p, Vec3 n, float error, Mask glossy, Mask active) const;
  /// Lanes that lie at a record, as the film has it: where --set irradiance-cache.view shows a point.
  Mask at_record(Vec3 p, Mask glossy, Mask active) const;

  const GlossyCache& glossy() const { return glossy_; }

 private:
  const float error_;
  RecordTree tree_;
  std::vector<IrradianceRecord> records_in_tree_order_;
  GlossyCache glossy_;
};

}  // namespace tessera::render::TESSERA_ISA
