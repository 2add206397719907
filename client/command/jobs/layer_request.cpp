#include "command/jobs/layer_request.h"

#include <algorithm>
#include <charconv>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "absl/strings/str_cat.h"
#include "base/nearest_name.h"

namespace tessera::client {
namespace {

/// The number of "bounce12".
std::optional<std::uint32_t> bounce_of(std::string_view word) {
  constexpr std::string_view kPrefix = "bounce";
  if (!word.starts_with(kPrefix)) return std::nullopt;
  word.remove_prefix(kPrefix.size());
  std::uint32_t number = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  if (error != std::errc{} || end != word.data() + word.size()) return std::nullopt;
  return number;
}

/// The name by which a light is known among others: that of its group, else its own.
std::string group_or_name(const v1::Light& light) {
  return light.group().empty() ? light.name() : light.group();
}
std::string lamp_name(const v1::Shape& shape) {
  for (const std::string& name : {shape.area_light().group(), shape.group()}) {
    if (!name.empty()) return name;
  }
  return shape.name();
}

std::set<std::string> light_names(const v1::Scene& scene) {
  std::set<std::string> names;
  for (const v1::Light& light : scene.lights()) names.insert(group_or_name(light));
  const auto add_lamps = [&](const auto& shapes) {
    for (const v1::Shape& shape : shapes)
      if (shape.has_area_light()) names.insert(lamp_name(shape));
  };
  add_lamps(scene.shapes());
  for (const v1::Object& object : scene.objects()) add_lamps(object.shapes());
  names.erase("");
  return names;
}

/// All names that an expression may have.
std::set<std::string> scene_names(const v1::Scene& scene) {
  std::set<std::string> names;
  const auto add_shapes = [&](const auto& shapes) {
    for (const v1::Shape& shape : shapes)
      names.insert({shape.name(), shape.group(), shape.area_light().group(), shape.material()});
  };
  add_shapes(scene.shapes());
  for (const v1::Object& object : scene.objects()) {
    names.insert(object.name());
    add_shapes(object.shapes());
  }
  for (const v1::Light& light : scene.lights()) names.insert({light.name(), light.group()});
  names.erase("");
  return names;
}

absl::Status check_layer_names(const std::vector<layers::Layer>& layers, const v1::Scene& scene) {
  const std::vector<std::string> asked = layers::names_in(layers);
  if (asked.empty()) return absl::OkStatus();
  const std::set<std::string> names = scene_names(scene);
  for (const std::string& name : asked) {
    if (names.contains(name)) continue;
    return absl::InvalidArgumentError(absl::StrCat("layers name '", name,
                                                   "', but nothing in the scene has this name",
                                                   base::did_you_mean(name, {names.begin(), names.end()})));
  }
  return absl::OkStatus();
}

void add_bounce_layers(std::uint32_t last, std::vector<layers::Layer>& layers) {
  for (std::uint32_t i = 0; i < last; ++i)
    layers.push_back({absl::StrCat("bounce", i), i == 0 ? "LE" : absl::StrCat("L.{", i, "}E")});
  layers.push_back({absl::StrCat("bounce", last), absl::StrCat("L.{", last, ",}E")});
}

/// Most events of paths whose strategies have layers of their own: 26 in all.
constexpr std::uint32_t kMostEvents = 5;

/// "s1t2" and the like, for all ways to make paths of up to `max_depth` events. Nothing joins a light itself
/// to the camera: light that is seen directly is met.
void add_strategy_layers(std::uint32_t max_depth, const char* before_name, const char* before_expression,
                         std::vector<layers::Layer>& layers) {
  for (std::uint32_t events = 0; events <= std::min(max_depth, kMostEvents); ++events) {
    for (std::uint32_t s = 0; s <= (events == 0 ? 0 : events + 1); ++s) {
      const std::string strategy = absl::StrCat("s", s, "t", events + 2 - s);
      layers.push_back({before_name + strategy, before_expression + strategy});
    }
  }
}

/// "light." and the name, in the letters that a layer's name may have.
std::string layer_name(const std::string& light, std::set<std::string>& taken) {
  constexpr std::string_view kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_";
  constexpr std::size_t kLongest = 48;
  std::string plain = light.substr(0, kLongest);
  for (char& c : plain) {
    if (kPlain.find(c) == std::string_view::npos) c = '_';
  }
  std::string name = absl::StrCat("light.", plain);
  for (int i = 2; !taken.insert(name).second; ++i) name = absl::StrCat("light.", plain, "_", i);
  return name;
}

absl::Status add_light_layers(const v1::Scene& scene, std::vector<layers::Layer>& layers) {
  const std::set<std::string> names = light_names(scene);
  if (names.size() >= layers::kMaxLayers) {
    return absl::InvalidArgumentError(absl::StrCat("--aov lights: the scene has ", names.size(),
                                                   " names of lights; at most ", layers::kMaxLayers - 1,
                                                   " can be layers. A group may have one name"));
  }
  std::set<std::string> taken = {"light.rest"};
  std::string all;
  for (const std::string& name : names) {
    const char* const quote = name.find('\'') == std::string::npos ? "'" : "\"";
    const std::string quoted = absl::StrCat(quote, name, quote);
    layers.push_back({layer_name(name, taken), absl::StrCat("C.*<L.", quoted, ">")});
    absl::StrAppend(&all, quoted);
  }
  // Lights without a name, and media that emit.
  layers.push_back({"light.rest", all.empty() ? "C.*L" : absl::StrCat("C.*<L.[^", all, "]>")});
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<bool> take_layer_word(const std::string& word, LayerRequest& asked) {
  const std::pair<const char*, bool*> plain_words[] = {
      {"lights", &asked.lights},
      {"emission", &asked.emission},
      {"shadow", &asked.shadow},
      {"strategies", &asked.strategies},
      {"unweighted-strategies", &asked.unweighted_strategies}};
  for (const auto& [name, is_asked] : plain_words) {
    if (word != name) continue;
    *is_asked = true;
    return true;
  }
  if (!word.starts_with("bounce")) return false;
  constexpr std::uint32_t kMost = layers::kMaxLayers - 1;
  const std::size_t dots = word.find("..");
  const auto first = bounce_of(std::string_view(word).substr(0, dots)),
             last = dots == std::string::npos ? first : bounce_of(std::string_view(word).substr(dots + 2));
  if (first && last && *first == 0 && *last > 0 && *last <= kMost) {
    asked.bounces = *last;
    return true;
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "'", word, "' is no range of bounces; bounce0..bounceN with N from 1 to ", kMost, " was expected"));
}

absl::StatusOr<std::vector<layers::Layer>> layers_of_job(const LayerRequest& asked, const v1::Scene& scene,
                                                         std::uint32_t max_depth) {
  std::vector<layers::Layer> layers;
  if (asked.layers) {
    layers = *asked.layers;
  } else {
    for (const v1::Layer& layer : scene.settings().layers())
      layers.push_back({layer.name(), layer.expression()});
  }
  if (auto s = check_layer_names(layers, scene); !s.ok()) return s;
  if (asked.bounces) add_bounce_layers(*asked.bounces, layers);
  if (asked.lights) {
    if (auto s = add_light_layers(scene, layers); !s.ok()) return s;
  }
  if (asked.emission) layers.push_back({"emission", "LE"});
  if (asked.shadow) layers.push_back({"shadow", "shadow:L(D|G|V)S*E"});
  if (asked.strategies) {
    add_strategy_layers(max_depth, "", "", layers);
    if (max_depth > kMostEvents) layers.push_back({"longer", absl::StrCat("d", kMostEvents + 1, "+")});
  }
  if (asked.unweighted_strategies) add_strategy_layers(max_depth, "unweighted.", "unweighted ", layers);
  return layers;
}

}  // namespace tessera::client
