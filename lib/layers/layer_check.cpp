// Layers as they come in: names, texts, and whether an automaton of them is possible.
#include "layers/layer_check.h"

#include <algorithm>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "layers/layer_rule.h"

namespace tessera::layers {

namespace {

constexpr std::size_t kShown = 200;  // characters of an expression in messages

bool is_name(const std::string& name) {
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
  const auto fits = [&](char c) { return is_letter(c) || (c >= '0' && c <= '9') || c == '-' || c == '.'; };
  return !name.empty() && name.size() <= kMaxName && is_letter(name.front()) && name.back() != '.' &&
         std::ranges::all_of(name, fits);
}

/// Names of the other channels of pictures.
bool is_taken(const std::string& name) {
  static const std::set<std::string> taken = {"R",      "G",     "B",       "A",     "variance", "albedo",
                                              "normal", "depth", "samples", "alpha", "id",       "visits"};
  return taken.contains(name.substr(0, name.find('.')));
}

absl::Status check_name(const std::string& name, std::set<std::string>& seen) {
  const std::string shown = name.substr(0, kMaxName);
  if (!is_name(name)) {
    return absl::InvalidArgumentError(
        absl::StrCat("'", shown,
                     "' is no name of a layer: letters, digits, '_', '-' and '.' were expected, a "
                     "letter first, at most ",
                     kMaxName));
  }
  if (is_taken(name))
    return absl::InvalidArgumentError(absl::StrCat("layer '", shown, "' has the name of other channels"));
  if (!seen.insert(name).second)
    return absl::InvalidArgumentError(absl::StrCat("layer '", shown, "' is there twice"));
  return absl::OkStatus();
}

/// Every layer has some path. Those with names are not looked at: it depends on the scene.
absl::Status check_held(std::span<const Layer> layers, const Automaton& automaton) {
  std::uint32_t some = 0;
  for (const std::int32_t found : automaton.layers) some |= static_cast<std::uint32_t>(found);
  for (std::size_t i = 0; i < layers.size(); ++i) {
    if ((some >> i & 1) != 0 || !names_in(layers.subspan(i, 1)).empty()) continue;
    return absl::InvalidArgumentError(absl::StrCat(
        "layer '", layers[i].name, "': no path is like ", layers[i].expression.substr(0, kShown),
        ": each has one light at its one end, the camera at the other, and only events in between"));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<Node> paths_of(const Layer& layer) {
  absl::StatusOr<LayerRule> rule = parse_rule(layer.expression);
  if (rule.ok()) return std::move(rule->paths);
  return absl::InvalidArgumentError(absl::StrCat("layer '", layer.name, "': ", rule.status().message(),
                                                 ", in ", layer.expression.substr(0, kShown)));
}

std::vector<std::string> names_in(std::span<const Layer> layers) {
  std::vector<std::string> names;
  for (const Layer& layer : layers) {
    const auto rule = parse_rule(layer.expression);
    if (rule.ok()) collect_names(rule->paths, names);
  }
  std::ranges::sort(names);
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

absl::Status check_layers(std::span<const Layer> layers) {
  if (layers.empty()) return absl::OkStatus();
  if (layers.size() > kMaxLayers) {
    return absl::InvalidArgumentError(
        absl::StrCat("there are ", layers.size(), " layers; at most ", kMaxLayers, " were expected"));
  }
  std::set<std::string> seen;
  for (const Layer& layer : layers) {
    if (auto s = check_name(layer.name, seen); !s.ok()) return s;
  }
  for (const Layer& layer : layers) {
    if (const auto paths = paths_of(layer); !paths.ok()) return paths.status();
  }
  const std::vector<std::string> names = names_in(layers);
  if (names.size() > kMaxNames) {
    return absl::InvalidArgumentError(
        absl::StrCat("layers have ", names.size(), " names; at most ", kMaxNames, " were expected"));
  }
  // The things that a scene calls so are not known here: each name is one of an object, of a material and of
  // a light.
  Alphabet alphabet;
  for (const std::string& name : names) {
    alphabet.surfaces.push_back({{name}, {}});
    alphabet.surfaces.push_back({{}, {name}});
    alphabet.lights.push_back({name});
  }
  for (const Direction direction : {Direction::kFromCamera, Direction::kFromLights}) {
    const auto automaton = compile(layers, alphabet, direction);
    if (!automaton.ok()) return absl::InvalidArgumentError(automaton.status().message());
    if (auto s = check_held(layers, *automaton); !s.ok()) return s;
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<Layer>> parse_layers(const std::string& text) {
  std::vector<Layer> layers;
  std::size_t begin = 0;
  for (;;) {
    char quote = 0;
    bool braces = false;
    std::size_t end = begin;
    for (; end < text.size() && (quote != 0 || braces || text[end] != ','); ++end) {
      const char c = text[end];
      if (quote != 0) {
        if (c == quote) quote = 0;
      } else if (c == '\'' || c == '"') {
        quote = c;
      } else if (c == '{' || c == '}') {
        braces = c == '{';
      }
    }
    const std::size_t equals = text.find('=', begin);
    if (equals == std::string::npos || equals >= end || equals == begin || equals + 1 == end)
      return absl::InvalidArgumentError(
          absl::StrCat("column ", begin + 1, ": NAME=EXPRESSION was expected, as in caustics=LS+DE"));
    layers.push_back({text.substr(begin, equals - begin), text.substr(equals + 1, end - equals - 1)});
    if (end == text.size()) return layers;
    begin = end + 1;
  }
}

}  // namespace tessera::layers
