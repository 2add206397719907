// The structures of the courses as kernels ask them.
#pragma once

#include "render/accel/structure/scene_structure.h"

namespace tessera::render::TESSERA_ISA {

const StructureKernel& structure_kernel();

}  // namespace tessera::render::TESSERA_ISA
