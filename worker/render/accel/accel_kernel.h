// The interface between a kernel module and the builders of acceleration structures.
#pragma once

#include "render/accel/embree/embree_kernel.h"
#include "render/accel/structure/scene_structure.h"

namespace tessera::render {

struct AccelKernel {
  const EmbreeKernel& embree;
  const StructureKernel& structures;
};

}  // namespace tessera::render
