// Exports of a kernel module.
#include "render/accel/accel_entry.h"
#include "render/accel/arithmetic.h"
#include "render/integrator/algorithm_list.h"
#include "render/integrator/stage_timer.h"
#include "render/kernel/kernel.h"
#include "render/light/light.h"
#include "render/query/query_entry.h"

#define TESSERA_STRING2(x) #x
#define TESSERA_STRING(x) TESSERA_STRING2(x)

namespace tessera::render::TESSERA_ISA {
namespace {

std::uint64_t read_clock() { return clock_ticks(); }

}  // namespace

const Kernel& kernel() {
  static const Kernel exported{TESSERA_STRING(TESSERA_ISA), &accel_kernel(), &query_kernel(),
                               listed_algorithms(),         light_sources(), &read_clock,
                               &arithmetic_checksum};
  return exported;
}

}  // namespace tessera::render::TESSERA_ISA

extern "C" __attribute__((visibility("default"))) const tessera::render::Kernel* tessera_kernel() {
  return &tessera::render::TESSERA_ISA::kernel();
}
