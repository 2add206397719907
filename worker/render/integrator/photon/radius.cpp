#include "render/integrator/photon/radius.h"

#include <algorithm>
#include <vector>

#include "render/camera/camera.h"
#include "render/integrator/vertex/lanes.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// Measured: docs/decisions/0030-photons.md.
constexpr float kFootprints = 3;

constexpr int kGrid = 32;  // rays each way
static_assert(kGrid % kWidth == 0 && kGrid * kGrid <= kBatch);

/// The camera's ray through the middle of its lens, in the middle of the exposure.
CameraRay central_ray(const CameraRecord& camera, Vec2 film) {
  const Float half(0.5f);
  return sample_camera_ray(camera, film, {half, half}, half);
}

Vec2 place_on_film(const CameraRecord& camera, int ray) {
  const Float column = to_float(Int::iota(ray % kGrid)) + 0.5f;
  const float row = static_cast<float>(ray / kGrid) + 0.5f;
  return {column * (static_cast<float>(camera.width) / kGrid),
          Float(row * static_cast<float>(camera.height) / kGrid)};
}

}  // namespace

float radius_by_footprint(const SceneTables& scene, const RayQuery& rays) {
  Vec3Lanes origin, direction;
  alignas(64) Lanes<float> time;
  HitState hits;
  for (int i = 0; i < kGrid * kGrid; i += kWidth) {
    const CameraRay ray = central_ray(scene.camera, place_on_film(scene.camera, i));
    store_lanes(ray.origin, origin, i);
    store_lanes(ray.direction, direction, i);
    Float(0.5f).store(time + i);
  }
  rays.nearest(arrays_of(origin, direction, scene.any_motion ? time : nullptr), kGrid * kGrid, false,
               hits.arrays());
  std::vector<float> footprints;
  for (int i = 0; i < kGrid * kGrid; i += kWidth) {
    const Vec2 film = place_on_film(scene.camera, i);
    const CameraRay here = central_ray(scene.camera, film),
                    beside = central_ray(scene.camera, {film.x, film.y + 1.0f});
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
