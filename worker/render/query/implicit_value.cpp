#include "render/query/query_entry.h"
#include "render/shape/implicit/double_functions.h"
#include "render/shape/implicit/run_program.h"

namespace tessera::render::TESSERA_ISA {

double implicit_value(const ImplicitRecord& surface, const double (&p)[3]) {
  alignas(64) double lanes[kWidth];
  run_program(surface.program, Double(p[0]), Double(p[1]), Double(p[2])).store(lanes);
  return lanes[0];
}

}  // namespace tessera::render::TESSERA_ISA
