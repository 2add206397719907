// No structure at all: every ray is tested against everything. The judge of the others.
#pragma once

#include <cstdint>

#include "render/accel/structure/figures.h"

namespace tessera::render {

struct Brute {
  std::uint32_t count = 0;  // primitives
  StructureFigures figures;
};

}  // namespace tessera::render
