// Cameras whose rays to a point are closest to that of an eye, for unstructured lumigraphs.
#pragma once

#include <cstdint>
#include <vector>

#include "light_field/grid_lookup.h"

namespace tessera::light_field {

class NearestCameras {
 public:
  explicit NearestCameras(const LightField& field);

  /// Cameras worth weighing for rays near `ray`, which meets something at `p`: the best by penalty, at most
  /// kCandidates, in the order of their numbers.
  void candidates(const LocalRay& ray, const Imath::V3f& p, std::vector<std::uint32_t>& views) const;
  /// How far a camera's ray to `p` is from the eye's, as the sine of the angle (beyond 90 degrees, 2 less
  /// it), with the loss of resolution where it stands farther off [Buehler et al. 2001, section 4.2]. `eye`:
  /// distance from the ray's origin to `p`.
  float penalty(std::uint32_t view, const LocalRay& ray, const Imath::V3f& p) const;
  /// Rays farther than this from those of all cameras are missing.
  float limit() const { return limit_; }

  static constexpr std::size_t kCandidates = 10;

 private:
  std::vector<Imath::V3f> places_;
  float limit_ = 0;
};

}  // namespace tessera::light_field
