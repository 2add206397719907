#include "render/shape/analytic_shape.h"

#include <algorithm>
#include <cmath>

namespace tessera::render::TESSERA_ISA {
namespace {

constinit ModelTable<AnalyticShape, ShapeKind> models;

}  // namespace

const AnalyticShape* analytic_shape(ShapeKind kind) { return models[kind]; }

void set_model(ShapeKind kind, const AnalyticShape& model) { models.set(kind, model); }

ShapeKind add_analytic_shape(const AnalyticShape& model) { return models.add(model); }

void AnalyticShape::crossings(const ShapeTable& table, const ShapeRecord& shape, std::int32_t primitive,
                              const ExactRay& ray, std::vector<double>& found) const {
  // From where the ray comes to the shape's box: floats are finer there than where it begins.
  const ShapeBounds box = bounds(table, shape, primitive);
  double along = 0, squared = 0, reach = 0;
  for (int k = 0; k < 3; ++k) {
    const double low = box.low[k], high = box.high[k];
    along += ((low + high) / 2 - ray.o[k]) * ray.d[k], squared += ray.d[k] * ray.d[k];
    reach += (high - low) / 2;
  }
  const double start = std::max((along / std::sqrt(squared) - reach) / std::sqrt(squared), 0.0);
  const auto single = [](double x) { return Float(static_cast<float>(x)); };
  ShapeRays rays{{single(ray.at(0, start)), single(ray.at(1, start)), single(ray.at(2, start))},
                 {single(ray.d[0]), single(ray.d[1]), single(ray.d[2])},
                 Float(0.0f),
                 Float(__builtin_inff()),
                 Mask::first(1)};
  constexpr int kMostSteps = 4096;  // a surface that noise has folded may be crossed without end
  for (int i = 0; i < kMostSteps; ++i) {
    const float t = nearest(table, shape, primitive, rays).lane(0);
    if (!(t > 0)) return;
    found.push_back(start + double{t});
    rays.t_near = Float(std::max(t * (1 + 0x1p-21f), std::nextafter(t, __builtin_inff())));
  }
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
