#include "render/accel/structure/clip.h"

namespace tessera::render {

namespace {

/// A triangle cut by six planes has at most nine corners.
struct ClippedPolygon {
  double p[10][3];
  int n = 0;
};

/// Keeps what lies on the side of x[axis] = at that `sign` says: 1 for above, -1 for below.
void cut(const ClippedPolygon& from, int axis, double at, double sign, ClippedPolygon& to) {
  to.n = 0;
  for (int i = 0; i < from.n; ++i) {
    const double* const a = from.p[i];
    const double* const b = from.p[i + 1 == from.n ? 0 : i + 1];
    const double da = sign * (a[axis] - at), db = sign * (b[axis] - at);
    if (da >= 0) std::copy_n(a, 3, to.p[to.n++]);
    if ((da < 0 && db > 0) || (da > 0 && db < 0)) {
      double* const c = to.p[to.n++];
      for (int k = 0; k < 3; ++k) c[k] = a[k] + (b[k] - a[k]) * (da / (da - db));
      c[axis] = at;
    }
  }
}

/// The float at or below x, and at or above it.
float round_down(double x) {
  const auto f = static_cast<float>(x);
  return f <= x ? f : std::nextafter(f, -Box::kInfinity);
}
float round_up(double x) { return -round_down(-x); }

}  // namespace

Box part_within(const Primitive& primitive, const Box& cell) {
  const Box whole = box_of(primitive);
  const Box overlap = whole.within(cell);
  if (overlap.empty() || primitive.kind != PrimitiveKind::kTriangle) return overlap;
  ClippedPolygon polygon, next;
  polygon.n = 3;
  for (int i = 0; i < 3; ++i) std::copy_n(primitive.corners[i], 3, polygon.p[i]);
  for (int axis = 0; axis < 3; ++axis) {
    if (whole.low[axis] < cell.low[axis]) {
      cut(polygon, axis, cell.low[axis], 1, next);
      std::swap(polygon, next);
    }
    if (whole.high[axis] > cell.high[axis]) {
      cut(polygon, axis, cell.high[axis], -1, next);
      std::swap(polygon, next);
    }
  }
  Box part;
  for (int i = 0; i < polygon.n; ++i) {
    for (int k = 0; k < 3; ++k) {
      part.low[k] = std::min(part.low[k], round_down(polygon.p[i][k]));
      part.high[k] = std::max(part.high[k], round_up(polygon.p[i][k]));
    }
  }
  return part.within(cell);
}

}  // namespace tessera::render
