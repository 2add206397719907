#include "render/scene/view/layers.h"

#include <algorithm>
#include <map>
#include <string>
#include <unordered_map>
#include <utility>

#include "layers/layer_rule.h"
#include "render/scene/values/light_records.h"

namespace tessera::render {

namespace {

/// A shape's message, and the object that it belongs to, if any.
struct PlacedShape {
  const v1::Shape* shape;
  const v1::Object* object;
};

/// In the order of their numbers.
std::vector<PlacedShape> all_shapes(const v1::Scene& scene) {
  std::vector<PlacedShape> result;
  for (const v1::Shape& shape : scene.shapes()) result.push_back({&shape, nullptr});
  for (const v1::Object& object : scene.objects()) {
    for (const v1::Shape& shape : object.shapes()) result.push_back({&shape, &object});
  }
  return result;
}

/// Those of some names that layers ask for, in order, each once.
class AskedNames {
 public:
  explicit AskedNames(std::span<const layers::Layer> layers) : names_(layers::names_in(layers)) {}

  bool empty() const { return names_.empty(); }
  std::vector<std::string> among(std::vector<std::string> names) const {
    std::erase_if(names, [&](const std::string& name) { return !std::ranges::binary_search(names_, name); });
    std::ranges::sort(names);
    names.erase(std::unique(names.begin(), names.end()), names.end());
    return names;
  }

 private:
  std::vector<std::string> names_;
};

/// Numbers of equal names, from that of those that have none.
template <class Names>
class Labels {
 public:
  explicit Labels(std::vector<Names>& alphabet) : alphabet_(alphabet) { label_of(Names{}); }

  std::int32_t label_of(const Names& names) {
    const auto [found, is_new] = labels_.try_emplace(names, static_cast<std::int32_t>(labels_.size()));
    if (is_new) alphabet_.push_back(names);
    return found->second;
  }
  bool all_alike() const { return labels_.size() == 1; }

 private:
  std::vector<Names>& alphabet_;
  std::map<Names, std::int32_t> labels_;
};

layers::SurfaceNames names_of(const PlacedShape& placed, const AskedNames& asked) {
  const v1::Shape& shape = *placed.shape;
  return {asked.among({shape.name(), shape.group(), placed.object ? placed.object->name() : ""}),
          asked.among({shape.material()})};
}

void label_shapes(const std::vector<PlacedShape>& shapes, std::span<const std::int32_t> numbers,
                  const AskedNames& asked, layers::Alphabet& alphabet, LayerTable& table) {
  if (asked.empty()) return;
  alphabet.surfaces.clear();
  Labels<layers::SurfaceNames> labels(alphabet.surfaces);
  for (const std::int32_t number : numbers) {
    const std::int32_t label = labels.label_of(names_of(shapes[static_cast<std::size_t>(number)], asked));
    table.first_event_of_shape.push_back(layers::kEventStride * label);
  }
  if (labels.all_alike()) table.first_event_of_shape.clear();
}

layers::Source source_of(const LightRecord& light) {
  if (light.shape >= 0) return layers::Source::kSurface;
  return is_environment(light.kind) ? layers::Source::kBackground : layers::Source::kLamp;
}

/// Lights without a shape have the order of the scene's.
void label_lights(const v1::Scene& scene, const std::vector<PlacedShape>& shapes,
                  std::span<const std::int32_t> numbers, const std::vector<LightRecord>& lights,
                  const AskedNames& asked, layers::Alphabet& alphabet, LayerTable& table) {
  alphabet.lights.clear();
  Labels<std::vector<std::string>> labels(alphabet.lights);
  int free_lights = 0, records = 0;  // records: of the light `free_lights` that have been labelled
  for (const LightRecord& light : lights) {
    std::vector<std::string> names;
    if (light.shape >= 0) {
      const v1::Shape& shape =
          *shapes[static_cast<std::size_t>(numbers[static_cast<std::size_t>(light.shape)])].shape;
      names = {shape.area_light().group(), shape.name(), shape.group()};
    } else if (free_lights < scene.lights_size()) {
      const v1::Light& message = scene.lights(free_lights);
      names = {message.name(), message.group()};
      if (++records == records_of(message)) ++free_lights, records = 0;
    }
    const std::int32_t label = labels.label_of(asked.among(std::move(names)));
    table.source_of_light.push_back(layers::kSources * label + static_cast<std::int32_t>(source_of(light)));
  }
  const std::vector<std::int32_t>& sources = table.source_of_light;
  if (!sources.empty() && std::ranges::count(sources, sources.front()) == std::ssize(sources))
    table.one_source = sources.front();
}

/// Whether some state goes on differently after diffuse and glossy events.
bool tells_lobes(const layers::Automaton& automaton) {
  for (std::size_t first = 0; first < automaton.next.size(); first += layers::kEventStride) {
    const auto next = [&](layers::Event event) {
      return automaton.next[first + static_cast<std::size_t>(event)];
    };
    using layers::Event;
    if (next(Event::kDiffuseReflection) != next(Event::kGlossyReflection) ||
        next(Event::kDiffuseTransmission) != next(Event::kGlossyTransmission)) {
      return true;
    }
  }
  return false;
}

/// `shadows`: bits of the layers of light that something is in the way of.
LayerAutomaton table_of(layers::Automaton automaton, std::int32_t shadows) {
  LayerAutomaton table{.states = automaton.states,
                       .events = automaton.events,
                       .ends = automaton.ends,
                       .begin = std::move(automaton.begin),
                       .next = std::move(automaton.next),
                       .layers = std::move(automaton.layers),
                       .shadows = {}};
  if (shadows != 0) table.shadows = table.layers;
  for (std::int32_t& found : table.layers) found &= ~shadows;
  for (std::int32_t& found : table.shadows) found &= shadows;
  return table;
}

/// Which part of their paths' light layers hold; returns the bits of shadows.
std::int32_t take_rules(std::span<const layers::Layer> layers, LayerTable& table) {
  std::int32_t shadows = 0;
  for (std::size_t i = 0; i < layers.size(); ++i) {
    const auto bit = static_cast<std::int32_t>(1u << i);
    const absl::StatusOr<layers::LayerRule> rule = layers::parse_rule(layers[i].expression);
    if (!rule.ok()) continue;  // rules have been checked before
    switch (rule->part) {
      case layers::Part::kAll:
        table.of_any_strategy |= bit;
        break;
      case layers::Part::kShadow:
        shadows |= bit;
        break;
      case layers::Part::kUnweighted:
        table.unweighted |= bit;
        [[fallthrough]];
      case layers::Part::kOfStrategies:
        table.of_strategies.push_back({rule->strategies, bit});
        break;
    }
  }
  table.has_shadows = shadows != 0;
  return shadows;
}

}  // namespace

std::vector<std::int32_t> shape_numbers(const v1::Scene& scene, std::span<const v1::Shape* const> messages) {
  std::unordered_map<const v1::Shape*, std::int32_t> number_of;
  for (const PlacedShape& placed : all_shapes(scene))
    number_of.emplace(placed.shape, static_cast<std::int32_t>(number_of.size()));
  std::vector<std::int32_t> result;
  for (const v1::Shape* const message : messages) result.push_back(number_of.at(message));
  return result;
}

absl::StatusOr<LayerTable> build_layers(const v1::Scene& scene, std::span<const layers::Layer> layers,
                                        wire::LayerStates states, std::span<const std::int32_t> numbers,
                                        const SceneArrays& arrays) {
  const AskedNames asked(layers);
  const std::vector<PlacedShape> shapes = all_shapes(scene);
  LayerTable table;
  layers::Alphabet alphabet;
  label_shapes(shapes, numbers, asked, alphabet, table);
  label_lights(scene, shapes, numbers, arrays.lights.lights, asked, alphabet, table);

  const std::int32_t shadows = take_rules(layers, table);
  auto from_camera = layers::compile(layers, alphabet, layers::Direction::kFromCamera);
  if (!from_camera.ok()) return from_camera.status();
  table.count = static_cast<std::int32_t>(layers.size());
  table.tells_lobes = tells_lobes(*from_camera);
  if (states == wire::LayerStates::kFromBothEnds) {
    auto from_lights = layers::compile(layers, alphabet, layers::Direction::kFromLights);
    if (!from_lights.ok()) return from_lights.status();
    table.joined = layers::layers_of_joins(*from_camera, *from_lights);
    for (std::int32_t& found : table.joined) found &= ~shadows;
    table.from_lights = table_of(*std::move(from_lights), shadows);
  }
  table.from_camera = table_of(*std::move(from_camera), shadows);
  table.source_of_media = static_cast<std::int32_t>(layers::Source::kMedium);
  return table;
}

}  // namespace tessera::render
