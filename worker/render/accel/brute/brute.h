// No structure at all: every ray is tested against everything. The judge of the others.
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "render/accel/structure/figures.h"
#include "render/accel/structure/primitive.h"
#include "render/accel/structure/structure_options.h"

namespace tessera::render {

struct Brute {
  std::uint32_t count = 0;  // primitives
  StructureFigures figures;
};

/// Every structure has one of these; some are told by which rule to build as well. It may change the order of
/// the primitives. ResourceExhausted where a bound of memory is reached. Throws Stopped once a stop is
/// requested.
absl::Status build_tree(const StructureOptions& options, std::vector<Primitive>& primitives, Brute& tree);

}  // namespace tessera::render
