// A binary tree of spheres [Whitted 1980; Rubin & Whitted 1980], walked best first: a heap gives the nearest
// sphere next [Kay & Kajiya 1986, sec. 4].
#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

#include "absl/status/status.h"
#include "render/accel/structure/figures.h"
#include "render/accel/structure/primitive.h"
#include "render/accel/structure/structure_options.h"

namespace tessera::render {

struct SphereNode {
  float centre[3] = {0, 0, 0};
  float radius = 0;
  std::int32_t child[2] = {0, 0};  // leaves: the first primitive, and ~ how many
};

struct SphereTree {
  std::vector<SphereNode> nodes;  // depth first, the root first; none where there are no primitives
  StructureFigures figures;
};

/// Brings the primitives into the order of the leaves. Halves at the median object, as the BVH does.
SphereTree build_sphere_tree(std::vector<Primitive>& primitives, int threads, std::stop_token stop = {});
absl::Status build_tree(const StructureOptions& options, std::vector<Primitive>& primitives,
                        SphereTree& tree);

}  // namespace tessera::render
