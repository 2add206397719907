#include "render/transport/photon/radius.h"

#include <algorithm>
#include <vector>

#include "render/sensor/sensor.h"
#include "render/transport/vertex/lanes.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// Measured: docs/decisions/0030-photons.md.
constexpr float kFootprints = 3;

constexpr int kGrid = 32;  // rays each way
static_assert(kGrid % kWidth == 0 && kGrid * kGrid <= kBatch);

/// The ray through the middle of the lens, in the middle of the exposure.
SensorRay central_ray(const SensorRecord& sensor, Vec2 raster) {
  const Float half(0.5f);
  return start_ray(sensor, {raster, {half, half}, half});
}

Vec2 place_on_raster(const SensorRecord& sensor, int ray) {
  const Float column = to_float(Int::iota(ray % kGrid)) + 0.5f;
  const float row = static_cast<float>(ray / kGrid) + 0.5f;
  return {column * (static_cast<float>(sensor.width) / kGrid),
          Float(row * static_cast<float>(sensor.height) / kGrid)};
}

}  // namespace

float radius_by_footprint(const SceneTables& scene, const RayQuery& rays) {
  Vec3Lanes origin, direction;
  alignas(64) Lanes<float> time;
  HitState hits;
  for (int i = 0; i < kGrid * kGrid; i += kWidth) {
    const SensorRay ray = central_ray(scene.sensor, place_on_raster(scene.sensor, i));
    store_lanes(ray.origin, origin, i);
    store_lanes(ray.direction, direction, i);
    Float(0.5f).store(time + i);
  }
  rays.nearest(arrays_of(origin, direction, scene.any_motion ? time : nullptr), kGrid * kGrid, false,
               hits.arrays());
  std::vector<float> footprints;
  for (int i = 0; i < kGrid * kGrid; i += kWidth) {
    const Vec2 raster = place_on_raster(scene.sensor, i);
    const SensorRay here = central_ray(scene.sensor, raster),
                    beside = central_ray(scene.sensor, {raster.x, raster.y + 1.0f});
    const Float t = Float::load(hits.t + i);
    const Float footprint =
        length(fma(beside.direction, t, beside.origin) - fma(here.direction, t, here.origin));
    const Mask seen = (Int::load(hits.shape + i) >= 0) & is_finite(footprint) & (footprint > 0.0f);
    alignas(64) float packed[2 * kWidth];
    const int n = compress_store(footprint, seen, packed);
    footprints.insert(footprints.end(), packed, packed + n);
  }
  if (footprints.empty()) return 0.01f * scene.lights.scene_radius;
  const auto median = footprints.begin() + static_cast<std::ptrdiff_t>(footprints.size() / 2);
  std::nth_element(footprints.begin(), median, footprints.end());
  return kFootprints * *median;
}

}  // namespace tessera::render::TESSERA_ISA
