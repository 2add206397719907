// Light path expressions: which paths of light a layer of a picture holds, in Heckbert's notation from the
// light [Heckbert 1990] or in that of Open Shading Language from the camera. docs/layers.md explains them.
//
//   expression  = choice                       with E as its last symbol, or C as its first
//   choice      = sequence { "|" sequence }
//   sequence    = repetition { repetition }
//   repetition  = symbol { "*" | "+" | "?" | "{" n [ "," [ m ] ] "}" }
//   symbol      = letter | "." | "<" kind [ lobe ] { names } ">" | "[" [ "^" ] { symbol } "]"
//                 | "(" choice ")"
//   letter      = C E | L O B | D G S | R T V
//   kind, lobe  = letter | "." | "[" [ "^" ] { letter } "]"
//   names       = [ "o" | "m" ] ( "'" name "'" | "[" [ "^" ] { "'" name "'" } "]" )
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "layers/event.h"

namespace tessera::layers {

/// Kinds of things that have names.
enum class Scope : std::uint8_t { kAny, kObject, kMaterial };

/// Holds for what has one of these names, or, negated, none of them. Lights have names without a scope.
struct NameTest {
  Scope scope = Scope::kAny;
  bool negated = false;
  std::vector<std::string> names = {};
};

/// Points of a path: the eye, events and sources in bits, those of them for which all tests hold.
struct PointSet {
  bool eye = false;
  std::uint32_t events = 0;   // bit 1 << Event
  std::uint32_t sources = 0;  // bit 1 << Source
  std::vector<NameTest> tests = {};
};

/// A node of an expression's tree.
struct Node {
  enum class Kind : std::uint8_t { kSymbol, kSequence, kChoice, kRepeat };
  Kind kind = Kind::kSymbol;
  // kSymbol: one of these points; negated, an event or a source that is none of them.
  bool negated = false;
  std::vector<PointSet> points = {};
  // The other kinds have children; kRepeat has one, which stands there `least` to `most` times.
  std::vector<Node> children = {};
  int least = 1;
  int most = 1;  // kForEver: without end
};
inline constexpr int kForEver = -1;

/// Longest expression, characters; deepest nesting of it; largest number in braces.
inline constexpr std::size_t kMaxExpression = 4096;
inline constexpr int kMaxNesting = 32;
inline constexpr int kMaxRepetitions = 256;

/// The tree of an expression, in the order from the camera in whichever notation it is written.
/// InvalidArgument, "column 3: ...", where it is none.
absl::StatusOr<Node> parse_expression(std::string_view text);

/// All names in the tree.
void collect_names(const Node& node, std::vector<std::string>& names);

}  // namespace tessera::layers
