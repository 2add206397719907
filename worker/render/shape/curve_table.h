// Curves as the kernels and Embree read them.
#pragma once

#include <cstdint>
#include <vector>

namespace tessera::render {

enum class CurveKind : std::int32_t { kFlat, kCylinder, kRibbon };

struct alignas(16) CurvePoint {
  float position[3] = {0, 0, 0};
  float radius = 0;
};

/// The cubic segments of one shape, in render space or, in an Object, in instance space.
struct CurvesRecord {
  CurveKind kind = CurveKind::kFlat;
  std::int32_t bspline = 0;  // uniform B-splines; else Bezier
  std::vector<CurvePoint> points;
  std::vector<std::uint32_t> starts;  // first of four control points of every segment: primitives
  std::vector<float>
      normals;  // kRibbon: x y z a control point, unit, and one float more for Embree's wide loads
  std::vector<float> params;  // u at the beginning and the end of every segment; empty: 0 and 1
  std::int32_t pieces = 4;    // straight pieces that a segment is as good as
  // Curves that deform: the `points` of the keys, at evenly spaced times from 0 to 1, follow one another,
  // all of a point is linear in between, and this many segments lie between the keys. The normals stay.
  std::int32_t key_segments = 0;
};

}  // namespace tessera::render
