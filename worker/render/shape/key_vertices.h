// Shapes that deform: vertices, or control points, of several keys, at evenly spaced times from 0 (the
// shutter opens) to 1, and linear in between, here as in Embree (ShapeRecord::key_segments).
#pragma once

#include <algorithm>
#include <cstdint>

#include "render/shape/shape_table.h"

namespace tessera::render {

/// A time between two keys.
struct KeyTime {
  std::int32_t before = 0;  // the key before it; the one behind follows
  float part = 0;           // of the way between the two

  KeyTime(std::int32_t segments, float time) {
    const float place = time * static_cast<float>(segments);
    before = std::clamp(static_cast<std::int32_t>(place), 0, std::max(segments - 1, 0));
    part = place - static_cast<float>(before);
  }
};

/// Vertex `vertex` of a mesh at the key `key`.
inline const Vertex& key_vertex(const ShapeTable& table, const ShapeRecord& mesh, std::uint32_t vertex,
                                std::int32_t key) {
  return table.vertices[static_cast<std::size_t>(mesh.first_vertex) +
                        static_cast<std::size_t>(key) * static_cast<std::size_t>(mesh.vertex_count) + vertex];
}

/// Corners of triangle `number` of a mesh at `time`.
inline void corners_at(const ShapeTable& table, const ShapeRecord& mesh, std::int32_t number, float time,
                       float (&corners)[3][3]) {
  const KeyTime at(mesh.key_segments, time);
  const std::uint32_t* const row =
      table.triangles.data() +
      3 * (static_cast<std::size_t>(mesh.first_triangle) + static_cast<std::size_t>(number));
  for (int c = 0; c < 3; ++c) {
    const float* const a = key_vertex(table, mesh, row[c], at.before).position;
    const float* const b = key_vertex(table, mesh, row[c], at.before + 1).position;
    for (int k = 0; k < 3; ++k) corners[c][k] = (1 - at.part) * a[k] + at.part * b[k];
  }
}

/// The axis of segment `number` of curves at its parameter `u` at `time`.
inline void axis_at(const CurvesRecord& curves, std::int32_t number, float u, float time, double (&axis)[3]) {
  const KeyTime at(curves.key_segments, time);
  const std::size_t count = curves.points.size() / (static_cast<std::size_t>(curves.key_segments) + 1);
  const CurvePoint* const a = curves.points.data() + static_cast<std::size_t>(at.before) * count +
                              curves.starts[static_cast<std::size_t>(number)];
  const double v = 1.0 - u;
  const double bezier[4] = {v * v * v, 3 * u * v * v, 3.0 * u * u * v, double{u} * u * u};
  const double bspline[4] = {bezier[0] / 6, (4 - 6.0 * u * u + 3 * bezier[3]) / 6,
                             (4 - 6 * v * v + 3 * bezier[0]) / 6, bezier[3] / 6};
  for (int k = 0; k < 3; ++k) {
    axis[k] = 0;
    for (int i = 0; i < 4; ++i) {
      const double next = curves.key_segments > 0 ? a[count + static_cast<std::size_t>(i)].position[k] : 0;
      const double place = (1 - double{at.part}) * a[i].position[k] + double{at.part} * next;
      axis[k] += (curves.bspline ? bspline : bezier)[i] * place;
    }
  }
}

}  // namespace tessera::render
