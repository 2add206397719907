// The sphere of directions, cut finely where a density is large or hard to integrate.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "support/kernel/bsdf_cases.h"
#include "support/kernel/chi2.h"

namespace tessera::test {

/// Cells with the integral of a density over each. A tree of halvings in (cos theta, phi), each
/// across the longer side.
class Partition {
 public:
  /// `density(directions, values)` gives the density at sixteen directions. Cells around the directions
  /// `peaks` are cut until they are smaller than `peak_radius` (radians), so that no narrow lobe is
  /// overlooked, and all cells are cut `least_depth` times, so that no part of an edge is.
  template <class Density>
  Partition(const Density& density, std::vector<Direction> peaks, double peak_radius, int least_depth = 0)
      : peaks_(std::move(peaks)), peak_radius_(peak_radius), least_depth_(least_depth) {
    for (int row = 0; row < kRows; ++row) {
      for (int column = 0; column < kColumns; ++column) {
        const SphereCell cell =
            SphereGrid(kRows, kColumns).bounds(static_cast<std::size_t>(row * kColumns + column));
        nodes_.push_back({cell, -1, -1});
      }
    }
    for (int root = 0; root < kRows * kColumns; ++root)
      refine(density, root, gauss(density, nodes_[root].cell), 0);
  }

  /// Integral over each cell; neighbours are mostly close in the order.
  const std::vector<double>& masses() const { return masses_; }

  double total() const {
    double sum = 0;
    for (const double mass : masses_) sum += mass;
    return sum;
  }

  /// The cell that a unit direction of single precision lies in.
  int cell(const Direction& w) const {
    // Near the poles x and y say more of the angle than z does.
    const double x2_y2 = w[0] * w[0] + w[1] * w[1];
    const double z = x2_y2 < 0.5 ? std::copysign(std::sqrt(1 - x2_y2), w[2]) : w[2];
    int node = static_cast<int>(SphereGrid(kRows, kColumns).cell(w[0], w[1], z));
    double phi = std::atan2(w[1], w[0]);
    if (phi < 0) phi += 2 * std::numbers::pi;
    while (nodes_[node].first_child >= 0) {
      const SphereCell& c = nodes_[node].cell;
      const bool upper = cuts_z(c) ? z > 0.5 * (c.z0 + c.z1) : phi > 0.5 * (c.phi0 + c.phi1);
      node = nodes_[node].first_child + (upper ? 1 : 0);
    }
    return nodes_[node].leaf;
  }

 private:
  static constexpr int kRows = 8, kColumns = 8;
  static constexpr int kMaxDepth = 44;
  static constexpr double kTolerance = 5e-7;  // error of the integral over one cell
  static constexpr double kMaxMass = 0.01;    // bound for one cell: the histogram's resolution
  static constexpr double kMaxEdgeMass = 1e-5;
  static constexpr int kEdgeDepth = 8;

  struct Node {
    SphereCell cell;
    int first_child;  // the second one follows it; -1: a leaf
    int leaf;
  };

  static Direction at(double z, double phi) {
    const double r = std::sqrt(std::max(0.0, 1 - z * z));
    return {r * std::cos(phi), r * std::sin(phi), z};
  }

  template <class Density>
  static double gauss(const Density& density, const SphereCell& c) {
    Direction w[16];
    float values[16];
    for (int i = 0; i < 16; ++i) {
      w[i] = at(c.z0 + (c.z1 - c.z0) * kGaussPoints[i / 4], c.phi0 + (c.phi1 - c.phi0) * kGaussPoints[i % 4]);
    }
    density(w, values);
    double sum = 0;
    for (int i = 0; i < 16; ++i) sum += kGaussWeights[i / 4] * kGaussWeights[i % 4] * values[i];
    return sum * c.solid_angle();
  }

  /// Whether the density vanishes on part of the cell's border only: Gauss points, which all lie within, may
  /// not see it.
  template <class Density>
  static bool has_edge(const Density& density, const SphereCell& c) {
    Direction w[16];
    float values[16];
    for (int i = 0; i < 16; ++i) {
      const double t = i % 4 / 4.0, u = i < 8 ? t : 1 - t;  // along the four sides
      const bool along_z = i / 4 == 1 || i / 4 == 3;
      w[i] = at(std::lerp(c.z0, c.z1,
                          along_z ? u
                          : i < 8 ? 0.0
                                  : 1.0),
                std::lerp(c.phi0, c.phi1, along_z ? (i < 8 ? 1.0 : 0.0) : u));
    }
    density(w, values);
    const auto zeros = std::count(std::begin(values), std::end(values), 0.0f);
    return zeros > 0 && zeros < 16;
  }

  static bool cuts_z(const SphereCell& c) {
    const double nearest_equator = c.z0 * c.z1 < 0 ? 0 : std::min(std::abs(c.z0), std::abs(c.z1));
    return std::acos(c.z0) - std::acos(c.z1) >
           (c.phi1 - c.phi0) * std::sqrt(1 - nearest_equator * nearest_equator);
  }

  static std::array<SphereCell, 2> halves(const SphereCell& c) {
    const double z = 0.5 * (c.z0 + c.z1), phi = 0.5 * (c.phi0 + c.phi1);
    if (cuts_z(c)) return {SphereCell{c.z0, z, c.phi0, c.phi1}, SphereCell{z, c.z1, c.phi0, c.phi1}};
    return {SphereCell{c.z0, c.z1, c.phi0, phi}, SphereCell{c.z0, c.z1, phi, c.phi1}};
  }

  bool must_cut(const SphereCell& c) const {
    const Direction centre = at(0.5 * (c.z0 + c.z1), 0.5 * (c.phi0 + c.phi1));
    double radius = 0;
    for (const double z : {c.z0, c.z1}) {
      for (const double phi : {c.phi0, c.phi1}) {
        radius = std::max(radius, std::acos(std::clamp(dot(centre, at(z, phi)), -1.0, 1.0)));
      }
    }
    if (radius <= peak_radius_) return false;
    return std::any_of(peaks_.begin(), peaks_.end(), [&](const Direction& peak) {
      return std::acos(std::clamp(dot(centre, peak), -1.0, 1.0)) < 1.2 * radius;
    });
  }

  template <class Density>
  void refine(const Density& density, int node, double coarse, int depth) {
    const SphereCell cell = nodes_[node].cell;
    SphereCell quarters[4];
    split(cell, quarters);
    double sum = 0;
    for (const SphereCell& quarter : quarters) sum += gauss(density, quarter);
    // Edges are followed where there is much to lose, and where nothing was seen at all.
    const bool follows_edge = sum >= kMaxEdgeMass || (sum == 0 && depth < least_depth_ + kEdgeDepth);
    const bool good = depth >= least_depth_ && std::abs(sum - coarse) < kTolerance && sum < kMaxMass &&
                      !must_cut(cell) && !(follows_edge && has_edge(density, cell));
    if (good || depth == kMaxDepth) {
      nodes_[node].leaf = static_cast<int>(masses_.size());
      masses_.push_back(sum);
      return;
    }
    const int first = static_cast<int>(nodes_.size());
    nodes_[node].first_child = first;
    for (const SphereCell& half : halves(cell)) nodes_.push_back({half, -1, -1});
    for (int child = first; child < first + 2; ++child) {
      refine(density, child, gauss(density, nodes_[child].cell), depth + 1);
    }
  }

  std::vector<Direction> peaks_;
  double peak_radius_;
  int least_depth_;
  std::vector<Node> nodes_;
  std::vector<double> masses_;
};

}  // namespace tessera::test
