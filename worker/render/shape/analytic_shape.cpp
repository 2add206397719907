#include "render/shape/analytic_shape.h"

#include <cassert>
#include <cmath>
#include <cstddef>

namespace tessera::render::TESSERA_ISA {
namespace {

constexpr std::size_t kMostModels = 64;

/// In the order of ShapeKind; filled when the kernels are loaded, so that asking costs one load.
const AnalyticShape* models[kMostModels] = {
    nullptr,           &sphere_shape(), &disk_shape(),       &cylinder_shape(),
    &sdf_grid_shape(), nullptr,         &half_space_shape(), &frustum_shape(),
    &polygon_shape(),  &box_shape(),    &polyhedron_shape(), &torus_shape(),
    &implicit_shape(), &csg_shape()};
std::size_t model_count = static_cast<std::size_t>(ShapeKind::kCount);

}  // namespace

const AnalyticShape* analytic_shape(ShapeKind kind) { return models[static_cast<std::size_t>(kind)]; }

ShapeKind add_analytic_shape(const AnalyticShape& model) {
  assert(model_count < kMostModels);
  models[model_count] = &model;
  return static_cast<ShapeKind>(model_count++);
}

ShapeBounds placed_bounds(const Affine& transform, const float (&centre)[3], const float (&half)[3]) {
  const float* m = transform.m;
  ShapeBounds b;
  for (int i = 0; i < 3; ++i) {
    const float* row = m + 4 * i;
    const float middle = row[0] * centre[0] + row[1] * centre[1] + row[2] * centre[2] + row[3];
    const float reach = std::abs(row[0]) * half[0] + std::abs(row[1]) * half[1] + std::abs(row[2]) * half[2];
    const float slack = 4e-6f * (std::abs(middle) + reach);
    b.low[i] = middle - reach - slack;
    b.high[i] = middle + reach + slack;
  }
  return b;
}

}  // namespace tessera::render::TESSERA_ISA
