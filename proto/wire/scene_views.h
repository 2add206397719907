// Scenes with several cameras (Scene.views), as jobs render them.
#pragma once

#include <cstdint>

#include "absl/status/status.h"
#include "tessera/v1/job.pb.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::wire {

/// How many views a job's picture has.
inline std::uint32_t views_of(const v1::JobSpec& job) {
  return job.cut().views() == 0 ? 1 : job.cut().views();
}

/// The view of a unit of the picture.
inline std::uint32_t view_of(const v1::WorkUnit& unit) {
  return unit.has_pass() ? unit.pass().view() : unit.tile().view();
}

/// Camera of a view, which the scene must have.
inline const v1::Camera& camera_of(const v1::Scene& scene, std::uint32_t view) {
  return view == 0 ? scene.camera() : scene.views(static_cast<int>(view) - 1);
}

/// Whether a camera has a film without a screen window, that goes around it.
inline bool sees_all_around(const v1::Camera& camera) {
  return camera.has_spherical() || camera.has_cylindrical() || camera.has_panorama() || camera.has_cube_map();
}

/// Place of the scene's camera, world space; the origin where it was not moved.
v1::Point3 camera_place(const v1::Scene& scene);

/// Leaves a scene one view, as its camera. All views of a scene have one render_origin, the place of the
/// first where the scene has none, so that renderers share what they build. InvalidArgument where there is no
/// such view.
absl::Status keep_view(std::uint32_t view, v1::Scene& scene);

/// Gives a scene with a rig the cameras that it stands for, as its camera and views. InvalidArgument names
/// what is wrong with the rig.
absl::Status resolve_rig(v1::Scene& scene);

/// Sampler's seed of a job's view: views have different noise, and each that of a picture of its own with
/// this seed.
inline std::uint64_t seed_of(const v1::JobSpec& job, std::uint32_t view) { return job.view().seed() + view; }

}  // namespace tessera::wire
