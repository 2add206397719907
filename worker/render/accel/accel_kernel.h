// What kernels give to those who build the structures that answer rays.
#pragma once

#include "render/accel/embree/embree_kernel.h"
#include "render/accel/structure/scene_structure.h"

namespace tessera::render {

struct AccelKernel {
  const EmbreeKernel& embree;
  const StructureKernel& structures;
};

}  // namespace tessera::render
