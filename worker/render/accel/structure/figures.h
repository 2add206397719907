// Figures of a structure that need no ray.
#pragma once

#include <cstddef>
#include <cstdint>

namespace tessera::render {

/// The surface area heuristic [MacDonaldBooth1990]: the cost of a ray is what it is expected to visit,
/// and a convex cell within another is met by a random line with the ratio of their areas. Costs are those of
/// Wald and Havran: a step down a tree 15, a test of a primitive 20 [Wald2006, sec. 5].
inline constexpr double kStepCost = 15, kTestCost = 20;

/// Figures of one structure, or of those of a world and its objects together.
struct StructureFigures {
  std::uint64_t primitives = 0;
  std::uint64_t nodes = 0;   // nodes that have children; a grid has none
  std::uint64_t leaves = 0;  // leaves that hold primitives; a grid's cells that do
  std::uint64_t empty_leaves = 0;
  std::uint64_t references = 0;  // primitives of all leaves; one in several leaves counts for each
  std::uint64_t bytes = 0;
  std::int32_t depth = 0;  // steps from the root to the deepest leaf
  double sah_cost = 0;     // cost of the world's; 0 where the structure has no such measure

  void add(const StructureFigures& other) {
    primitives += other.primitives, nodes += other.nodes, leaves += other.leaves;
    empty_leaves += other.empty_leaves, references += other.references, bytes += other.bytes;
    depth = depth > other.depth ? depth : other.depth;
  }
};

}  // namespace tessera::render
