// The scene as a rasteriser takes it: shapes in pieces of some dozens of primitives, each with a box.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "render/core/big_array.h"
#include "render/core/vec.h"
#include "render/shape/shape_table.h"

namespace tessera::render::TESSERA_ISA {

inline constexpr int kClusterSize = 64;  // primitives

/// Boxes side by side, in the space that their primitives are given in.
struct Boxes {
  BigArray<float> low[3], high[3];
};

struct WideBox {
  Vec3 low, high;
};

/// Shapes where they stand: in the world, or by an instance.
struct Draw {
  std::int32_t shape;
  std::int32_t instance;        // -1: none
  std::uint64_t first_cluster;  // clusters are counted through all draws
};

class Clusters {
 public:
  /// Counts them; what fill() is called for is the rest.
  explicit Clusters(const ShapeTable& shapes);

  /// Finds the boxes of clusters [first, last); any number of threads may do so for different ones.
  void fill(std::size_t first, std::size_t last);

  /// The number of clusters of all shapes, each shape counted once.
  std::size_t size() const { return count_; }
  /// Clusters as they are drawn: those of an object once an instance.
  std::uint64_t drawn() const { return drawn_; }
  const std::vector<Draw>& draws() const { return draws_; }
  /// The draw that the `place`-th of all drawn clusters belongs to.
  std::size_t draw_at(std::uint64_t place) const;

  std::size_t first_of(std::int32_t shape) const { return first_[static_cast<std::size_t>(shape)]; }
  std::size_t count_of(std::int32_t shape) const { return first_of(shape + 1) - first_of(shape); }
  /// Primitives of a cluster of the shape, `index` counting from 0 within it.
  int primitives(std::int32_t shape, std::size_t index) const;

  /// 16 boxes from cluster `first` on; those beyond the last hold anything.
  WideBox boxes(std::size_t first) const;
  /// The boxes of 16 primitives of a shape whose primitives are no triangles.
  WideBox primitive_boxes(std::int32_t shape, std::int32_t first, Mask active) const;

 private:
  const ShapeTable& shapes_;
  std::vector<std::size_t> first_;  // cluster of each shape, and their number
  std::vector<std::int32_t> primitives_of_shape_;
  std::size_t count_ = 0;
  std::vector<Draw> draws_;
  std::uint64_t drawn_ = 0;
  Boxes boxes_;
};

}  // namespace tessera::render::TESSERA_ISA
