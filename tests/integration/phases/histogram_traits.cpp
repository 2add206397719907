#include "integration/phases/histogram_traits.h"

#include <array>

namespace tessera::integration {
namespace {

constexpr std::array kPhases{wire::PhaseTraits{.name = "seen", .parts = 5, .merge_width = 2},
                             wire::PhaseTraits{.name = "counts", .parts = 60, .merge_width = 4}};

// Before main.
[[maybe_unused]] const bool added = [] {
  wire::add_algorithm({.name = kHistogram, .bias = wire::Bias::kBiased, .phases = kPhases});
  return true;
}();

}  // namespace
}  // namespace tessera::integration
