#include "render/query/nearest_point.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace tessera::render {
namespace {

constexpr double kTurn = 2 * 3.14159265358979323846;

V3d nearest_on_segment(const V3d& p, const V3d& a, const V3d& b) {
  const V3d along = b - a;
  const double squared = along.length2();
  return squared > 0 ? a + along * std::clamp((p - a).dot(along) / squared, 0.0, 1.0) : a;
}

V3d nearer(const V3d& p, const V3d& a, const V3d& b) { return (b - p).length2() < (a - p).length2() ? b : a; }

/// Eigenvalues of a symmetric matrix, and its eigenvectors as columns: Jacobi's rotations
/// [Golub2013, sec. 8.5].
void diagonalise(double (&a)[3][3], double (&v)[3][3]) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) v[i][j] = i == j;
  }
  for (int sweep = 0; sweep < 30; ++sweep) {
    if (a[0][1] == 0 && a[0][2] == 0 && a[1][2] == 0) return;
    for (int p = 0; p < 2; ++p) {
      for (int q = p + 1; q < 3; ++q) {
        if (a[p][q] == 0) continue;
        const double theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
        const double t = std::copysign(1.0, theta) / (std::abs(theta) + std::hypot(theta, 1.0));
        const double c = 1 / std::hypot(t, 1.0), s = t * c;
        for (int k = 0; k < 3; ++k) {
          const double x = a[k][p], y = a[k][q];
          a[k][p] = c * x - s * y, a[k][q] = s * x + c * y;
        }
        for (int k = 0; k < 3; ++k) {
          const double x = a[p][k], y = a[q][k];
          a[p][k] = c * x - s * y, a[q][k] = s * x + c * y;
        }
        for (int k = 0; k < 3; ++k) {
          const double x = v[k][p], y = v[k][q];
          v[k][p] = c * x - s * y, v[k][q] = s * x + c * y;
        }
        a[p][q] = a[q][p] = 0;
      }
    }
  }
}

/// The point of a piece that is closest to (x, z); x may be below 0, on the axis' other side.
void nearest_on_piece(const ProfilePiece& piece, double x, double z, double& at_x, double& at_z) {
  const auto& [ax, az, bx, bz, radius, z_low, z_high] = piece;
  if (radius == 0) {
    const V3d q = nearest_on_segment({x, 0, z}, {ax, 0, az}, {bx, 0, bz});
    at_x = q.x, at_z = q.z;
    return;
  }
  const double dx = x - ax, dz = z - az, length = std::hypot(dx, dz);
  at_x = length > 0 ? ax + dx * radius / length : ax + radius,
  at_z = length > 0 ? az + dz * radius / length : az;
  if (at_z >= z_low && at_z <= z_high && at_x >= 0) return;
  // An end of the arc.
  double best = HUGE_VAL;
  for (const double end : {z_low, z_high}) {
    const double end_x = ax + std::sqrt(std::max(radius * radius - (end - az) * (end - az), 0.0));
    if (const double d = std::hypot(x - end_x, z - end); d < best) best = d, at_x = end_x, at_z = end;
  }
}

/// Factors by which a map scales lengths across the z axis and along it, if it keeps surfaces that turn about
/// that axis what they are, to 2^-18 of its scale.
struct AxialScale {
  double across, along;
};
std::optional<AxialScale> axial_scale(const ExactAffine& a) {
  double gram[3][3];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j)
      gram[i][j] = a.m[i] * a.m[j] + a.m[4 + i] * a.m[4 + j] + a.m[8 + i] * a.m[8 + j];
  }
  const double across = std::sqrt(gram[0][0]), along = std::sqrt(gram[2][2]);
  constexpr double kRoom = 0x1p-18;
  const bool square = std::abs(gram[0][1]) <= kRoom * across * across &&
                      std::abs(gram[0][2]) <= kRoom * across * along &&
                      std::abs(gram[1][2]) <= kRoom * across * along;
  if (!square || std::abs(std::sqrt(gram[1][1]) - across) > kRoom * across) return std::nullopt;
  return AxialScale{across, along};
}

}  // namespace

TrianglePoint nearest_on_triangle(const V3d& p, const V3d& a, const V3d& b, const V3d& c) {
  const V3d ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return {a, 0, 0};
  const V3d bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return {b, 1, 0};
  const V3d cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return {c, 0, 1};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) {
    const double v = d1 / (d1 - d3);
    return {a + ab * v, v, 0};
  }
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) {
    const double w = d2 / (d2 - d6);
    return {a + ac * w, 0, w};
  }
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {b + (c - b) * w, 1 - w, w};
  }
  const double inverse = 1 / (va + vb + vc), v = vb * inverse, w = vc * inverse;
  return {a + ab * v + ac * w, v, w};
}

V3d nearest_on_polygon(const V3d& p, std::span<const V3d> corners) {
  V3d normal{0, 0, 0};  // Newell's, about the first corner
  for (std::size_t i = 1; i + 1 < corners.size(); ++i)
    normal += (corners[i] - corners[0]).cross(corners[i + 1] - corners[0]);
  V3d best = nearest_on_segment(p, corners.back(), corners.front());
  for (std::size_t i = 0; i + 1 < corners.size(); ++i)
    best = nearer(p, best, nearest_on_segment(p, corners[i], corners[i + 1]));
  if (!(normal.length2() > 0)) return best;
  const V3d in_plane = p - normal * ((p - corners[0]).dot(normal) / normal.length2());
  // Seen along the axis that the normal is closest to.
  int axis = std::abs(normal.x) > std::abs(normal.y) ? 0 : 1;
  axis = std::abs(normal.z) > std::abs(normal[axis]) ? 2 : axis;
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  bool inside = false;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const V3d &a = corners[i], &b = corners[(i + 1) % corners.size()];
    if ((in_plane[v] < a[v]) == (in_plane[v] < b[v])) continue;
    const double side = (in_plane[u] - a[u]) * (b[v] - a[v]) - (in_plane[v] - a[v]) * (b[u] - a[u]);
    inside ^= (side < 0) != (b[v] < a[v]);
  }
  return inside ? in_plane : best;
}

V3d nearest_on_ellipsoid(const V3d& p, const ExactAffine& place, double radius) {
  // Minimise |L x - q|^2 over |x| = r, where q = p - shift: (L'L + m) x = L'q, in the axes of L'L.
  double gram[3][3], axes[3][3], b[3], own[3];
  const V3d q = p - V3d(place.m[3], place.m[7], place.m[11]);
  for (int i = 0; i < 3; ++i) {
    own[i] = place.m[i] * q.x + place.m[4 + i] * q.y + place.m[8 + i] * q.z;
    for (int j = 0; j < 3; ++j) {
      gram[i][j] =
          place.m[i] * place.m[j] + place.m[4 + i] * place.m[4 + j] + place.m[8 + i] * place.m[8 + j];
    }
  }
  diagonalise(gram, axes);
  for (int i = 0; i < 3; ++i) b[i] = axes[0][i] * own[0] + axes[1][i] * own[1] + axes[2][i] * own[2];
  const double d[3] = {gram[0][0], gram[1][1], gram[2][2]};
  const int least = static_cast<int>(std::min_element(d, d + 3) - d);
  const double length = std::sqrt(b[0] * b[0] + b[1] * b[1] + b[2] * b[2]);
  // m = -d[least] + s with s > 0: the length of x falls with s, from infinity unless b[least] is 0.
  double low = std::abs(b[least]) / radius, high = length / radius;
  const auto squared_length = [&](double s) {
    double sum = 0;
    for (int i = 0; i < 3; ++i) {
      const double x = b[i] / ((d[i] - d[least]) + s);
      sum += b[i] != 0 ? x * x : 0;
    }
    return sum;
  };
  for (int i = 0; i < 2000; ++i) {
    const double middle = low + (high - low) / 2;
    if (!(middle > low && middle < high)) break;
    (squared_length(middle) > radius * radius ? low : high) = middle;
  }
  double x[3], rest = radius * radius;
  for (int i = 0; i < 3; ++i) {
    const double below = (d[i] - d[least]) + high;
    x[i] = b[i] != 0 && below > 0 ? b[i] / below : 0;
    if (i != least) rest -= x[i] * x[i];
  }
  // From the middle of the shortest axis both ends are as near; rounding is put there too.
  x[least] = std::copysign(std::sqrt(std::max(rest, 0.0)), b[least]);
  const V3d nearest{axes[0][0] * x[0] + axes[0][1] * x[1] + axes[0][2] * x[2],
                    axes[1][0] * x[0] + axes[1][1] * x[1] + axes[1][2] * x[2],
                    axes[2][0] * x[0] + axes[2][1] * x[1] + axes[2][2] * x[2]};
  return apply(place, nearest * (radius / nearest.length()));
}

std::optional<V3d> nearest_on_round(const V3d& p, const ExactAffine& place, const ShapeTable& table,
                                    const ShapeRecord& shape, const QueryKernel& kernel) {
  const RoundForm* const form = kernel.round_form(shape.kind);
  if (form == nullptr) return std::nullopt;
  const auto quadric = static_cast<std::size_t>(shape.quadric);
  if (quadric >= table.quadrics.size()) return std::nullopt;
  const QuadricRecord& q = table.quadrics[quadric];
  std::vector<ProfilePiece> pieces = form->profile(q);
  const std::optional<AxialScale> scale = axial_scale(place);
  if (!scale) return std::nullopt;
  for (ProfilePiece& piece : pieces) {
    if (piece.radius != 0 && std::abs(scale->across - scale->along) > 0x1p-18 * scale->across)
      return std::nullopt;  // no arc of a circle any more
    piece.ax *= scale->across, piece.bx *= scale->across, piece.radius *= scale->across;
    for (double* const z : {&piece.az, &piece.bz, &piece.z_low, &piece.z_high}) *z *= scale->along;
  }
  // Lengths are those of the space of `p` from here on.
  V3d own = apply(inverse(place), p);
  own = {own.x * scale->across, own.y * scale->across, own.z * scale->along};
  std::optional<V3d> best;
  const auto try_at = [&](double cosine, double sine) {
    for (const ProfilePiece& piece : pieces) {
      double x = 0, z = 0;
      nearest_on_piece(piece, own.x * cosine + own.y * sine, own.z, x, z);
      const V3d found{x * cosine, x * sine, z};
      best = best ? nearer(own, *best, found) : found;
    }
  };
  const double phi = std::atan2(own.y, own.x), azimuth = phi < 0 ? phi + kTurn : phi;
  const bool whole = !q.partial || double{q.phi_max} >= kTurn * (1 - 1e-7);
  if (whole || azimuth <= double{q.phi_max}) try_at(std::cos(azimuth), std::sin(azimuth));
  if (!whole) {
    try_at(1, 0);
    try_at(std::cos(double{q.phi_max}), std::sin(double{q.phi_max}));
  }
  return apply(place, {best->x / scale->across, best->y / scale->across, best->z / scale->along});
}

double least_scale(const ExactAffine& map) {
  double gram[3][3], axes[3][3];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      gram[i][j] = 0;
      for (int row = 0; row < 12; row += 4) gram[i][j] += map.m[row + i] * map.m[row + j];
    }
  }
  diagonalise(gram, axes);
  const double least = std::min({gram[0][0], gram[1][1], gram[2][2]});
  const double rounding = 0x1p-48 * std::max({gram[0][0], gram[1][1], gram[2][2]});
  return std::sqrt(std::max(least - rounding, 0.0));
}

}  // namespace tessera::render
