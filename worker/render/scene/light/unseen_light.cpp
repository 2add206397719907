#include "render/scene/light/unseen_light.h"

#include <algorithm>
#include <array>
#include <optional>
#include <span>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "render/light/light_source.h"
#include "render/scene/light/sky_light.h"

namespace tessera::render {
namespace {

/// Marks a material that is used, and those that it is made of.
void mark(const std::vector<MaterialRecord>& materials, std::int32_t material, std::vector<bool>& used) {
  if (material < 0 || used[static_cast<std::size_t>(material)]) return;
  used[static_cast<std::size_t>(material)] = true;
  const MaterialRecord& record = materials[static_cast<std::size_t>(material)];
  if (record.flags & kMixed) {
    mark(materials, record.mix_a, used);
    mark(materials, record.mix_b, used);
  }
  if (record.flags & kHasBack) mark(materials, record.back, used);
}

std::vector<bool> used_materials(const SceneTables& tables) {
  std::vector<bool> used(tables.materials.materials.size());
  for (const ShapeRecord& shape : tables.shapes.shapes)
    mark(tables.materials.materials, shape.material, used);
  return used;
}

/// "light 'NAME'", or "lights[2]", of the first delta light; nothing where there is none.
std::optional<std::string> first_delta_light(const SceneTables& tables, const v1::Scene& scene) {
  const auto is_delta = [&](const LightRecord& light) {
    return tables.lights.sources(light.kind).traits.delta;
  };
  if (std::ranges::none_of(tables.lights.lights, is_delta)) return std::nullopt;
  for (int i = 0; i < scene.lights_size(); ++i) {
    if (scene.lights(i).has_infinite()) continue;
    if (scene.lights(i).has_sky() && !has_parallel_sun(scene.lights(i).sky())) continue;
    return scene.lights(i).name().empty() ? absl::StrCat("lights[", i, "]")
                                          : absl::StrCat("'", scene.lights(i).name(), "'");
  }
  return "a delta light";
}

/// "photon, vcm": algorithms without bias by design that are blind to nothing, or to `blindness` at most.
std::string algorithms_that_see(std::span<const wire::Blindness> at_most, bool media) {
  std::vector<std::string> names;
  for (const wire::AlgorithmTraits& other : wire::algorithms()) {
    if (other.bias == wire::Bias::kBiased || !(other.starts_at_lights) || (media && !other.media)) continue;
    if (std::ranges::find(at_most, other.blindness) != at_most.end()) names.emplace_back(other.name);
  }
  return absl::StrJoin(names, ", ");
}

}  // namespace

std::string unseen_light(const wire::AlgorithmTraits& algorithm, const SceneTables& tables,
                         const v1::Scene& scene, const std::vector<std::string>& material_names) {
  using wire::Blindness;
  const Blindness blindness = algorithm.blindness;
  if (blindness == Blindness::kNone) return "";
  // Scattering events of the shortest path that is not found: delta surfaces, and a surface that they light.
  // A probe is lit itself, without an event.
  const bool on_probes = tables.sensor.probes != nullptr;
  const bool at_camera = blindness == Blindness::kCausticsInMirrors && !on_probes;
  const int events = blindness == Blindness::kMirrorImages || on_probes ? 1 : at_camera ? 3 : 2;
  if (tables.max_depth < events) return "";

  const std::vector<MaterialRecord>& materials = tables.materials.materials;
  const std::vector<bool> used = used_materials(tables);
  std::optional<std::size_t> delta_surface;
  bool any_receiver = on_probes || !tables.media.media.empty();
  for (std::size_t m = 0; m < materials.size(); ++m) {
    if (!used[m] || (materials[m].flags & kMixed)) continue;
    if (!(materials[m].flags & kAllDelta)) any_receiver = true;
    const bool passed = algorithm.straight_shadows && tables.straight_shadows && is_clear_glass(materials[m]);
    if (!delta_surface && (materials[m].flags & kHasDeltaLobe) && !passed) delta_surface = m;
  }
  if (!delta_surface || !any_receiver) return "";
  const std::string surface = absl::StrCat(
      "material '", *delta_surface < material_names.size() ? material_names[*delta_surface] : "", "'");
  const bool media = !tables.media.media.empty();
  const std::string all_of_it = algorithms_that_see(std::array{Blindness::kNone}, media);
  if (blindness == Blindness::kMirrorImages) {
    return absl::StrCat(
        "integrator '", algorithm.name, "' does not see what is behind a mirror or clear glass, as ", surface,
        " is: it is black there; ",
        algorithms_that_see(std::array{Blindness::kNone, Blindness::kCausticsInMirrors}, media), " see it");
  }
  const std::optional<std::string> light = first_delta_light(tables, scene);
  if (!light) return "";
  const std::string caustics =
      absl::StrCat("the light of ", *light, ", which has no surface, by way of a mirror or clear glass, as ",
                   surface, " is");
  if (blindness == Blindness::kCaustics) {
    return absl::StrCat("integrator '", algorithm.name, "' never finds ", caustics, "; ", all_of_it,
                        " find it, and ",
                        algorithms_that_see(std::array{Blindness::kCausticsInMirrors}, media),
                        " where it is not seen in a mirror");
  }
  if (on_probes)
    return absl::StrCat("integrator '", algorithm.name, "' never finds ", caustics,
                        ", where it falls straight on a meter; light finds it");
  return absl::StrCat("integrator '", algorithm.name, "' never finds ", caustics,
                      ", where it is seen in a mirror or through glass; ", all_of_it, " find it");
}

}  // namespace tessera::render
