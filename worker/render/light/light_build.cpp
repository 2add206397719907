#include "render/light/light_build.h"

#include <algorithm>
#include <map>
#include <optional>

#include "render/light/light_source.h"

namespace tessera::render {

void append_area_lights(ShapeTable& shapes, std::int32_t shape, std::span<const float, 3> radiance,
                        bool two_sided, std::int32_t texture, LightTable& table, float interpolated_pick) {
  ShapeRecord& record = shapes.shapes[static_cast<std::size_t>(shape)];
  const std::optional<LightKind> kind = table.sources.on_shape(record.kind);
  if (!kind) return;
  record.first_light = static_cast<std::int32_t>(table.lights.size());
  LightRecord light;
  light.kind = *kind;
  light.shape = shape;
  light.two_sided = two_sided;
  light.texture = texture;
  std::copy(radiance.begin(), radiance.end(), light.radiance);
  const std::size_t first = table.lights.size();
  table.sources(*kind).append(shapes, record, light, interpolated_pick, table.lights);
  for (std::size_t i = first; i < table.lights.size(); ++i)
    table.any_interpolated = table.any_interpolated || table.lights[i].profile == kInterpolated;
}

AliasTable selection_of_lights(const LightTable& table, LightSelection kind) {
  AliasTable none;
  none.pmf.assign(table.lights.size(), 0.0f);
  if (kind == LightSelection::kNone) return none;
  // Most choices by power, some evenly among emitters: power alone starves a lamp beside a bright sky, whose
  // power grows with the scene's size. Measured: docs/decisions/0006-media-and-passing.md.
  const double by_power = kind == LightSelection::kPower ? 1 : kind == LightSelection::kUniform ? 0 : 0.75;
  std::vector<double> power;
  std::map<std::pair<std::int32_t, std::size_t>, double> emitters;  // a shape, or a light without one
  const auto emitter_of = [&](std::size_t i) {
    const std::int32_t shape = table.lights[i].shape;
    return std::pair{shape, shape >= 0 ? std::size_t{0} : i};
  };
  double total = 0;
  for (std::size_t i = 0; i < table.lights.size(); ++i) {
    power.push_back(sampled_power(table, table.lights[i]));
    total += power.back();
    emitters[emitter_of(i)] += power.back();
  }
  if (total == 0) return none;
  const auto shining = static_cast<double>(std::count_if(
      emitters.begin(), emitters.end(), [](const auto& emitter) { return emitter.second > 0; }));
  std::vector<double> weights(power.size(), 0);
  for (std::size_t i = 0; i < power.size(); ++i) {
    if (power[i] > 0)
      weights[i] =
          by_power * power[i] / total + (1 - by_power) / shining * power[i] / emitters[emitter_of(i)];
  }
  AliasTable selection = AliasTable::build(weights);
  for (std::size_t i = 0; i < power.size(); ++i) {
    if (const std::int32_t other = table.lights[i].same_as; other >= 0)
      selection.pmf[i] = selection.pmf[static_cast<std::size_t>(other)];
  }
  return selection;
}

}  // namespace tessera::render
