#include "integration/phases/latched_traits.h"

#include "wire/algorithm.h"

namespace tessera::integration {
namespace {

// Before main.
[[maybe_unused]] const bool added = [] {
  wire::AlgorithmTraits traits = *wire::find_algorithm("path");
  traits.name = kLatched;
  wire::add_algorithm(traits);
  return true;
}();

}  // namespace
}  // namespace tessera::integration
