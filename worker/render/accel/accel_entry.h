#pragma once

#include "render/accel/accel_kernel.h"

namespace tessera::render::TESSERA_ISA {

const AccelKernel& accel_kernel();

}  // namespace tessera::render::TESSERA_ISA
