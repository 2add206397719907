#include "render/accel/brute/brute.h"

namespace tessera::render {

absl::Status build_tree(const StructureOptions&, std::vector<Primitive>& primitives, Brute& tree) {
  tree.count = static_cast<std::uint32_t>(primitives.size());
  tree.figures.leaves = !primitives.empty();
  tree.figures.references = primitives.size();
  return absl::OkStatus();
}

}  // namespace tessera::render
