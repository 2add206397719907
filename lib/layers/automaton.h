// One automaton for all layers of a picture: its state goes along a path as a small integer, and says at the
// path's end which layers the path's light belongs to.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "layers/event.h"
#include "layers/limits.h"

namespace tessera::layers {

struct Layer {
  std::string name;        // begins the names of the picture's channels: NAME.R, NAME.G, NAME.B
  std::string expression;  // an expression, or more: layer_rule.h
};

/// The names that a surface has.
struct SurfaceNames {
  std::vector<std::string> objects;
  std::vector<std::string> materials;

  auto operator<=>(const SurfaceNames&) const = default;
};

/// Surfaces and lights that are to be told apart; each is a label.
struct Alphabet {
  std::vector<SurfaceNames> surfaces = {{}};
  std::vector<std::vector<std::string>> lights = {{}};
};

/// Where the paths begin that carry the state.
enum class Direction : std::uint8_t { kFromCamera, kFromLights };

/// Minimal, for paths of its direction. A path begins at one of `begins` points (the camera alone, or all
/// lights), and ends at one of `ends`.
struct Automaton {
  std::int32_t states = 0, events = 0, begins = 0, ends = 0;
  std::vector<std::int32_t> begin;   // the first state, for each point that paths begin at
  std::vector<std::int32_t> next;    // state after event e in state s: next[s * events + e]
  std::vector<std::int32_t> layers;  // bits of the layers of a path that ends at e: layers[s * ends + e]
};

/// The automaton of these layers, which have been checked. ResourceExhausted, naming the layer, where it
/// would be too large.
absl::StatusOr<Automaton> compile(std::span<const Layer> layers, const Alphabet& alphabet,
                                  Direction direction);

/// The layers of paths whose two parts, one read from the camera and one from the light, have come to these
/// states of automata of the same layers and alphabet: bits, [state from the camera * from_lights.states +
/// state from the light]. Events are in one of the two parts each.
std::vector<std::int32_t> layers_of_joins(const Automaton& from_camera, const Automaton& from_lights);

/// All names in the layers' expressions, each once, in order.
std::vector<std::string> names_in(std::span<const Layer> layers);

/// InvalidArgument, naming the layer, where there are too many, a name is there twice or is none, an
/// expression is none (with the column) or holds no path, or the automaton would be too large.
absl::Status check_layers(std::span<const Layer> layers);

/// "NAME=EXPRESSION,..." as on a command line. A comma within braces or quotes is part of its expression.
/// InvalidArgument, with the column of the text, where a layer has no name or no expression.
absl::StatusOr<std::vector<Layer>> parse_layers(const std::string& text);

}  // namespace tessera::layers
