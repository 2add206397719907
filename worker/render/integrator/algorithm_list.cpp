#include "render/integrator/algorithm_list.h"

#include <vector>

namespace tessera::render::TESSERA_ISA {
namespace {

/// Filled while kernels are loaded, in whatever order that takes their files.
std::vector<Algorithm>& list() {
  static std::vector<Algorithm> algorithms;
  return algorithms;
}

}  // namespace

std::span<const Algorithm> listed_algorithms() { return list(); }

ListedAlgorithm::ListedAlgorithm(const Algorithm& algorithm) { list().push_back(algorithm); }

}  // namespace tessera::render::TESSERA_ISA
