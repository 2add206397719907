// The text of a layer: which paths it holds, and what of their light.
//
//   rule     = expression | part [ ":" expression ]
//   part     = "shadow" | [ "unweighted" ] strategy
//   strategy = "s" ( n | "*" ) "t" ( n | "*" ) | "d" n "+"
//
// Without an expression a part is that of all paths.
#pragma once

#include <cstdint>
#include <string_view>

#include "absl/status/statusor.h"
#include "layers/expression.h"
#include "layers/strategies.h"

namespace tessera::layers {

/// Part of the light of some paths.
enum class Part : std::uint8_t {
  kAll,
  kOfStrategies,  // the share that the weights of some strategies give it
  kUnweighted,    // the light that some strategies find by themselves: each of its paths with a weight of 1
  kShadow         // light that does not arrive: something is between the light and the last event before it
};

struct LayerRule {
  Part part = Part::kAll;
  Strategies strategies = {};
  Node paths = {};
};

/// InvalidArgument, "column 3: ...", where the text is no rule.
absl::StatusOr<LayerRule> parse_rule(std::string_view text);

}  // namespace tessera::layers
