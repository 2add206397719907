// A change of variables that spreads the lobes of microfacets, however narrow, over the sphere: integrals of
// densities and histograms of samples are taken there. Directions wi correspond to normals of microfacets one
// to one (half vectors of reflection and of refraction), and those to slopes in units of roughness.
#pragma once

#include <cmath>

#include "support/kernel/bsdf_cases.h"

namespace tessera::test {

class HalfVectorMap {
 public:
  /// How light gets to the other side: bent by the index, or as if mirrored there (sheets without thickness).
  enum class Transmission { kRefracts, kMirrors };

  /// `eta` is the index below the surface over that above.
  HalfVectorMap(double alpha_x, double alpha_y, double eta, Transmission transmission, const Direction& wo)
      : ax_(alpha_x),
        ay_(alpha_y),
        eta_(wo[2] < 0 ? 1 / eta : eta),
        transmission_(transmission),
        below_(wo[2] < 0) {
    wo_ = mirrored(wo, below_);
  }

  struct Mapped {
    Direction wi;
    double jacobian;  // solid angle of wi over that of q; 0 where no wi corresponds to q
  };

  /// Maps a point q of the unit sphere: reflected light from the upper half, transmitted light from the
  /// lower.
  Mapped direction_of(const Direction& q) const {
    const double z = std::abs(q[2]), t = z * z * z, r = std::hypot(q[0], q[1]);
    const double slope = r > 0 ? std::sqrt(std::max(0.0, 1 - t * t)) / (t * r) : 0;
    if (t == 0) return {{0, 0, 1}, 0};
    Direction h{ax_ * slope * q[0], ay_ * slope * q[1], 1};
    const double zh = 1 / std::sqrt(dot(h, h));
    for (double& x : h) x *= zh;
    // dh = zh^3 d(slopes) = zh^3 ax ay / t^3 dt dphi, and dt = 3 z^2 dz.
    const double dh = zh * zh * zh * ax_ * ay_ / (t * t * t) * 3 * z * z;
    const double c = dot(wo_, h);
    if (c <= 0) return {{0, 0, 1}, 0};
    if (q[2] > 0 || transmission_ == Transmission::kMirrors) {
      const Direction wi{2 * c * h[0] - wo_[0], 2 * c * h[1] - wo_[1], 2 * c * h[2] - wo_[2]};
      return {mirrored(wi, below_ != (q[2] <= 0)), wi[2] > 0 ? 4 * c * dh : 0};
    }
    const double g2 = (eta_ - 1) * (eta_ + 1) + c * c, g = std::sqrt(std::max(g2, 0.0));
    Direction wi;
    for (int i = 0; i < 3; ++i) wi[i] = ((c - g) * h[i] - wo_[i]) / eta_;
    return {mirrored(wi, below_), g2 > 0 && wi[2] < 0 ? (c - g) * (c - g) / (eta_ * g) * dh : 0};
  }

  /// The point that direction_of() takes to wi.
  Direction point_of(const Direction& wi_of_either_side) const {
    Direction wi = mirrored(wi_of_either_side, below_);
    const bool transmitted = wi[2] < 0;
    if (transmitted && transmission_ == Transmission::kMirrors) wi[2] = -wi[2];
    const double scale = wi[2] < 0 ? eta_ : 1;
    Direction h{wo_[0] + scale * wi[0], wo_[1] + scale * wi[1], wo_[2] + scale * wi[2]};
    if (h[2] < 0) h = {-h[0], -h[1], -h[2]};
    const double x = h[0] / (ax_ * h[2]), y = h[1] / (ay_ * h[2]), slope2 = x * x + y * y;
    const double z = std::cbrt(1 / std::sqrt(1 + slope2)), r = std::sqrt(std::max(0.0, 1 - z * z));
    const double length = std::sqrt(slope2);
    if (length == 0) return {0, 0, transmitted ? -1.0 : 1.0};
    return {r * x / length, r * y / length, transmitted ? -z : z};
  }

 private:
  static Direction mirrored(const Direction& w, bool yes) { return {w[0], w[1], yes ? -w[2] : w[2]}; }

  double ax_, ay_, eta_;
  Transmission transmission_;
  bool below_;
  Direction wo_;
};

}  // namespace tessera::test
