#include "render/shape/csg/csg_mesh.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tessera::render::TESSERA_ISA {

namespace {

/// A line that is sheared to run along z [Woop, Benthin & Wald 2013].
class ShearedLine {
 public:
  ShearedLine(const double (&o)[3], const double (&d)[3]) {
    for (int i = 0; i < 3; ++i) o_[i] = o[i], inverse_[i] = 1 / (std::abs(d[i]) > 1e-300 ? d[i] : 1e-300);
    z_ = std::abs(d[0]) > std::abs(d[1]) ? (std::abs(d[0]) > std::abs(d[2]) ? 0 : 2)
                                         : (std::abs(d[1]) > std::abs(d[2]) ? 1 : 2);
    x_ = (z_ + 1) % 3, y_ = (z_ + 2) % 3;
    shear_x_ = d[x_] / d[z_], shear_y_ = d[y_] / d[z_];
  }

  bool meets(const CsgMesh::Node& box) const {
    double enter = -HUGE_VAL, leave = HUGE_VAL;
    for (int i = 0; i < 3; ++i) {
      const double a = (box.low[i] - o_[i]) * inverse_[i], b = (box.high[i] - o_[i]) * inverse_[i];
      enter = std::max(enter, std::min(a, b)), leave = std::min(leave, std::max(a, b));
    }
    return enter <= leave;
  }

  /// The ray parameter where the line passes through a triangle; false where it does not.
  bool crosses(const double* const (&corners)[3], double& s) const {
    double x[3], y[3], z[3];
    for (int c = 0; c < 3; ++c) {
      z[c] = corners[c][z_] - o_[z_];
      x[c] = corners[c][x_] - o_[x_] - shear_x_ * z[c];
      y[c] = corners[c][y_] - o_[y_] - shear_y_ * z[c];
    }
    double w[3];
    int left = 0;
    for (int c = 0; c < 3; ++c) {
      const int from = (c + 1) % 3, to = (c + 2) % 3;
      w[c] = x[from] * y[to] - y[from] * x[to];
      // On the edge's line, or beyond what doubles tell: as if the ray were moved along x by very little, and
      // along y by much less. The edge taken the other way has the other answer, as it has for all other w.
      const double dx = x[to] - x[from], dy = y[to] - y[from];
      left += w[c] != 0 ? w[c] > 0 : dy != 0 ? dy < 0 : dx > 0;
    }
    if (left != 0 && left != 3) return false;
    const double sum = w[0] + w[1] + w[2];
    // Seen edge-on, roundings alone say where on it; all places on it are as good.
    const double at = (w[0] * z[0] + w[1] * z[1] + w[2] * z[2]) / sum;
    const double low = std::min({z[0], z[1], z[2]}), high = std::max({z[0], z[1], z[2]});
    s = (at >= low && at <= high ? at : (low + high) / 2) * inverse_[z_];
    if (!std::isfinite(s)) return false;
    return true;
  }

 private:
  double o_[3], inverse_[3];
  double shear_x_, shear_y_;
  int x_, y_, z_;
};

void add_all(const CsgMesh& mesh, const ShearedLine& line, std::int32_t solid, CsgCrossings& crossings) {
  std::int32_t waiting[64];  // the tree halves its triangles, so it is no deeper
  int count = 0;
  waiting[count++] = 0;
  while (count > 0) {
    const std::int32_t index = waiting[--count];
    const CsgMesh::Node& node = mesh.nodes[static_cast<std::size_t>(index)];
    if (!line.meets(node)) continue;
    if (node.count == 0) {
      waiting[count++] = node.second;
      waiting[count++] = index + 1;
    }
    for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
      const std::int32_t triangle = mesh.order[static_cast<std::size_t>(i)];
      const std::uint32_t* const corner =
          mesh.triangles.data() + std::size_t{3} * static_cast<std::size_t>(triangle);
      const double* const p[3] = {mesh.positions.data() + 3 * std::size_t{corner[0]},
                                  mesh.positions.data() + 3 * std::size_t{corner[1]},
                                  mesh.positions.data() + 3 * std::size_t{corner[2]}};
      double s = 0;
      if (line.crosses(p, s)) crossings.add({s, solid, triangle});
    }
  }
}

}  // namespace

void add_crossings(const CsgMesh& mesh, const double (&o)[3], const double (&d)[3], std::int32_t solid,
                   CsgCrossings& crossings) {
  const std::size_t before = crossings.size();
  double from[3] = {o[0], o[1], o[2]};
  constexpr int kMostTries = 4;
  for (int i = 0; i < kMostTries; ++i) {
    add_all(mesh, ShearedLine(from, d), solid, crossings);
    if ((crossings.size() - before) % 2 == 0) return;
    // Signs at a corner that roundings left without a meaning; they have one a little beside it.
    crossings.cut(before);
    for (int a = 0; a < 3; ++a) from[a] += (a + 1) * 0x1p-40;
  }
}

}  // namespace tessera::render::TESSERA_ISA
