// All records of a picture, to be read by any number of threads.
#pragma once

#include <vector>

#include "render/color/spectrum.h"
#include "render/film/prepared.h"
#include "render/integrator/irradiance_cache/record.h"

namespace tessera::render::TESSERA_ISA {

/// Irradiance at 16 points, where some record reaches them.
struct Irradiance {
  Spectrum value;
  Mask found;
};

class IrradianceCache final : public Prepared {
 public:
  /// Records are used where their error is below `error`.
  IrradianceCache(std::vector<IrradianceRecord> records, float error);

  /// Interpolates at points `p` with normals `n`: the mean of the records that reach them, each extrapolated
  /// by its gradients and weighted by how far it is within its error [Ward & Heckbert 1992; the weights are
  /// those of Tabellion & Lamorlette 2004, which fall to zero]. A lane's bits do not depend on the others.
  Irradiance look_up(Vec3 p, Vec3 n, Mask active) const;
  /// Lanes that some record reaches with an error below `error`, which is not above that of the cache.
  Mask covers(Vec3 p, Vec3 n, float error, Mask active) const;
  /// Lanes that lie at a record, as the film has it: where --cache-view shows a point.
  Mask at_record(Vec3 p, Mask active) const;

  const std::vector<IrradianceRecord>& records() const { return records_; }

 private:
  /// A box around the spheres that the records from `first` on reach. Leaves have `count` records; else the
  /// next node is the one child, and `other` the second.
  struct Node {
    float low[3], high[3];
    std::int32_t first, count, other;
  };
  void build(std::size_t begin, std::size_t end);
  /// Calls visit(record) for all that may reach some of the points; those that reach a point come in the same
  /// order whatever the other lanes hold.
  template <class Visit>
  void visit(Vec3 p, Mask active, Visit&& visit) const;

  const float error_;
  std::vector<IrradianceRecord> records_;  // in the order of the leaves
  std::vector<Node> nodes_;
};

}  // namespace tessera::render::TESSERA_ISA
