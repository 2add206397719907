// A scene's shapes as lists of primitives: one for the world, one for each object.
#pragma once

#include <cstddef>
#include <cstdint>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "render/accel/structure/primitive.h"

namespace tessera::render {

struct InstanceRecord;
struct ShapeTable;
struct ShapeRecord;

/// Counts and bounds of analytic shapes as kernels know them, with the roundings of their own tests.
struct AnalyticBounds {
  std::int32_t (*count)(const ShapeTable& table, std::int32_t shape) = nullptr;
  Box (*bounds)(const ShapeTable& table, std::int32_t shape, std::int32_t primitive) = nullptr;
};

/// How many primitives a shape may add to a list.
std::size_t most_primitives(const ShapeTable& table, std::int32_t shape, const AnalyticBounds& analytic);

/// Adds what rays may meet of a shape: triangles with finite corners and an area (those that deform may have
/// none at times), and analytic shapes with finite bounds. InvalidArgument, with the shape's number, for
/// curves.
absl::Status add_primitives(const ShapeTable& table, std::int32_t shape, const AnalyticBounds& analytic,
                            std::vector<Primitive>& list, const std::stop_token& stop = {});

/// Where an instance has an object whose primitives lie in `object`, for all times together; empty where that
/// is.
Box box_of_instance(const ShapeTable& table, const InstanceRecord& instance, const Box& object);

/// Adds an instance that lies in `box`; `number` is its index among those of the world, or of all objects.
void add_instance(std::int32_t number, const Box& box, std::vector<Primitive>& list);

}  // namespace tessera::render
