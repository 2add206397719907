#include "render/transport/vertex/medium_at.h"

#include <algorithm>

#include "render/light/light_access.h"
#include "render/sensor/sensor.h"
#include "render/transport/vertex/dimensions.h"
#include "render/transport/vertex/passing.h"

namespace tessera::render::TESSERA_ISA {

WideConnection way_from_sensor(const SceneTables& scene, Vec3 point, Float time, Int slot) {
  WideConnection way{};
  way.origin = {Float(0.0f), Float(0.0f), Float(0.0f)};
  if (!scene.sensor.probes) {
    SensorSample middle = middle_sample(middle_of_raster(scene.sensor));
    middle.time = time;
    way.origin = start_ray(scene.sensor, middle).origin;
  }
  const Vec3 to = point - way.origin;
  way.distance = length(to);
  way.direction = to * (1.0f / max(way.distance, 1e-30f));
  way.slot = slot;
  way.time = time;
  way.medium = Int(scene.sensor.medium);
  return way;
}

void find_media(const IntegratorContext& context, ConnectionQueue& ways, HitState& hits,
                Lanes<std::int32_t>& media) {
  const SceneTables& scene = context.scene;
  int n = ways.size;
  for (int round = 0; n > 0 && round <= dimension::kMostCrossings; ++round) {
    context.rays.nearest(arrays_of(ways.origin, ways.direction, scene.any_motion ? ways.time : nullptr), n,
                         false, hits.arrays());
    context.stats.shadow_rays += static_cast<std::uint64_t>(n);
    int kept = 0;
    for (int i = 0; i < n; i += kWidth) {
      const Mask active = Mask::first(n - i);
      WideConnection way = load(scene, static_cast<const ConnectionFields<InMemory>&>(ways), i);
      Hit hit = load_hit(hits, i);
      if (scene.any_motion) hit.time = way.time;
      const Mask met = active & (hit.shape >= 0) & (hit.t < way.distance);
      // A thing on the way may be opaque: the medium behind it is told by its borders all the same.
      scatter(way.medium, media, way.slot, active);
      if (none(met)) continue;
      const Surface surface = surface_at(scene.shapes, hit, way.origin, way.direction, met, false);
      const Vec3 origin = offset_origin(surface, way.direction);
      way.medium = medium_behind(scene.shapes, surface, way.direction, way.medium, met);
      way.distance = way.distance - dot(origin - way.origin, way.direction);
      way.origin = origin;
      kept += append(scene, way, met, ways, kept);
    }
    n = kept;
  }
  ways.size = 0;
}

Int medium_at_light(const SceneTables& scene, Int light, Vec3 point, Vec3 direction, Int medium,
                    Mask active) {
  const LightRecord* const lights = scene.lights.lights.data();
  const Int shape = gather_member(lights, &LightRecord::shape, light, active);
  const Mask on_shape = active & (shape >= 0);
  if (none(on_shape)) return medium;
  // Any place on a triangle has its normal; quadrics are found again from a point near them.
  const Int primitive = gather_member(lights, &LightRecord::primitive, light, on_shape);
  const Hit hit{Float(0.0f), Float(0.3f), Float(0.3f), primitive, shape, Int(-1)};
  const Vec3 zero{Float(0.0f), Float(0.0f), Float(0.0f)};
  const Surface surface = surface_at(scene.shapes, hit, point, zero, on_shape, false);
  return medium_behind(scene.shapes, surface, direction, medium, on_shape);
}

Mask is_lost(const SceneTables& scene, Int light, Int medium, Mask active) {
  Mask lost = Mask::none();
  const Mask inside = active & (medium >= 0);
  for_each_distinct(kind_of(scene.lights, light, inside), inside, [&](std::int32_t kind, Mask lanes) {
    if (!light_model(static_cast<LightKind>(kind)).traits.at_infinity) return;
    for_each_distinct(medium, lanes, [&](std::int32_t index, Mask within) {
      const MediumRecord& record = scene.media.media[static_cast<std::size_t>(index)];
      const float* const sigma_t = record.sigma_t.value;
      if (record.homogeneous && std::any_of(sigma_t, sigma_t + kBands, [](float s) { return s > 0; }))
        lost |= within;
    });
  });
  return lost;
}

}  // namespace tessera::render::TESSERA_ISA
