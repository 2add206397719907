#include "render/accel/accel_kernel.h"

#include "render/accel/accel_entry.h"
#include "render/accel/embree/trace.h"
#include "render/accel/structure/structure_query.h"

namespace tessera::render::TESSERA_ISA {

const AccelKernel& accel_kernel() {
  static const AccelKernel kernel{embree_kernel(), structure_kernel()};
  return kernel;
}

}  // namespace tessera::render::TESSERA_ISA
