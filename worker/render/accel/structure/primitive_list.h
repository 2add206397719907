// A scene's shapes as lists of primitives: one for the world, one for each object.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "render/accel/structure/primitive.h"

namespace tessera::render {

struct ShapeTable;
struct ShapeRecord;

/// What kernels know of analytic shapes, with the roundings of their own tests.
struct AnalyticBounds {
  std::int32_t (*count)(const ShapeTable& table, std::int32_t shape) = nullptr;
  Box (*bounds)(const ShapeTable& table, std::int32_t shape, std::int32_t primitive) = nullptr;
};

/// Adds what rays may meet of a shape: triangles with finite corners and an area, and analytic shapes with
/// finite bounds. InvalidArgument, with the shape's number, for curves.
absl::Status add_primitives(const ShapeTable& table, std::int32_t shape, const AnalyticBounds& analytic,
                            std::vector<Primitive>& list);

/// Adds an instance of an object whose primitives lie in `object`, for all times together.
void add_instance(const ShapeTable& table, std::int32_t instance, const Box& object,
                  std::vector<Primitive>& list);

}  // namespace tessera::render
