// The balance of all light: what is emitted is absorbed, or escapes.
#include <cstddef>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "measure/placed_things.h"
#include "measure/planner.h"
#include "measure/surfaces.h"

namespace tessera::client {

using Imath::V3d;

namespace {

/// Both sides of all surfaces of a thing. InvalidArgument names what cannot be read.
absl::StatusOr<std::vector<ReceiverPlace>> sides_of(const PlacedThing& thing, const ImportedScene& scene) {
  if (!thing.obstacle.empty()) return fault(thing.obstacle);
  std::vector<ReceiverPlace> sides;
  for (const v1::Shape& shape : thing.shapes) {
    for (const bool back : {false, true}) {
      auto place = surface_of(shape, scene, back);
      if (!place.ok()) return place.status();
      sides.push_back(*std::move(place));
    }
  }
  return sides;
}

/// Tells in words where light is absorbed that nothing reads. `things`: those that are not read, and why.
std::string not_read(bool in_media, const std::vector<std::string>& things) {
  constexpr std::size_t kMostNamed = 3;
  std::vector<std::string> where;
  if (in_media) where.emplace_back("in media");
  for (std::size_t i = 0; i < things.size() && i < kMostNamed; ++i)
    where.push_back(absl::StrCat("by ", things[i]));
  if (things.size() > kMostNamed) where.push_back(absl::StrCat("by ", things.size() - kMostNamed, " more"));
  return absl::StrCat("'absorbed elsewhere' is what is left over: ", absl::StrJoin(where, ", "));
}

}  // namespace

absl::Status Planner::add_energy_balance() {
  const double square = square_metres();
  factor_ *= square;
  const v1::Scene& scene = scene_.imported.scene;
  for (const v1::Medium& medium : scene.media()) {
    if (medium.has_emission())
      return fault(absl::StrCat("medium '", medium.name(), "' glows: what media emit is not told"));
  }
  // Light that leaves the scene is scattered back to it, or absorbed on its way.
  if (!scene.camera().medium().empty())
    return fault(absl::StrCat("the camera is in medium '", scene.camera().medium(),
                              "', which may have no end: the balance is of what is within a ball"));
  PlannedReading emitted = add_reading("emitted"), escaped = add_reading("escaped"),
                 left_over = add_reading("residual");
  plan_.meters.back().readings.clear();
  const auto take = [&](const ReceiverPlace& place, v1::Probe::Kind kind, double sign, PlannedReading& to,
                        double in_rest, ReadLight light) {
    const std::size_t cell = add_probe(place, kind, light);
    to.terms.push_back({cell, sign * factor_ * place.area, channel_});
    left_over.terms.push_back({cell, in_rest * sign * factor_ * place.area, channel_});
  };
  // Light that comes in from infinity, and that of lamps without a surface, is what crosses a ball around the
  // scene where it is scattered nowhere; what things in its way take is theirs.
  const auto outside = hull(false), inside = hull(true);
  if (!outside.ok()) return outside.status();
  take(*outside, v1::Probe::PLANE, 1, emitted, 1, ReadLight::kStraight);
  take(*inside, v1::Probe::PLANE, 1, escaped, -1, ReadLight::kAll);
  for (const v1::Light& light : scene.lights()) {
    if (light.has_infinite() || light.has_distant() || light.has_sky()) continue;
    const auto lamp = flux_of_lamp(light, square);
    if (!lamp.ok()) return lamp.status();
    const double flux = *lamp * factor_;
    emitted.constant += flux, left_over.constant += flux;
  }
  std::vector<PlannedReading> absorbed;
  std::vector<std::string> others;
  for (const PlacedThing& thing : placed_things(scene)) {
    const auto sides = sides_of(thing, scene_.imported);
    if (!sides.ok()) {
      const std::string who = absl::StrCat("'", thing.name, "' (", sides.status().message(), ")");
      if (thing.shines) return fault(absl::StrCat(who, " emits light, of which the balance has to know"));
      others.push_back(who);
      continue;
    }
    PlannedReading& taken = absorbed.emplace_back();
    taken.label = absl::StrCat("absorbed by ", thing.name);
    taken.position = V3d(std::numeric_limits<double>::quiet_NaN());
    for (std::size_t side = 0; side < sides->size(); ++side) {
      const ReceiverPlace& place = (*sides)[side];
      take(place, v1::Probe::PLANE, 1, taken, -1, ReadLight::kAll);
      take(place, v1::Probe::EXITANCE, -1, taken, -1, ReadLight::kAll);
      if (!thing.shapes[side / 2].has_area_light()) continue;
      // Own light is emitted, and no part of what was not absorbed.
      const std::size_t own = add_probe(place, v1::Probe::EXITANCE, ReadLight::kStraight);
      const double factor = factor_ * place.area;
      emitted.terms.push_back({own, factor, channel_});
      taken.terms.push_back({own, factor, channel_});
    }
  }
  PlannedMeter& meter = plan_.meters.back();
  if (scene.media_size() > 0 || !others.empty()) {
    left_over.label = "absorbed elsewhere";
    meter.warnings.push_back(not_read(scene.media_size() > 0, others));
  }
  meter.readings.push_back(std::move(emitted));
  for (PlannedReading& taken : absorbed) meter.readings.push_back(std::move(taken));
  meter.readings.push_back(std::move(escaped));
  meter.readings.push_back(std::move(left_over));
  return absl::OkStatus();
}

}  // namespace tessera::client
