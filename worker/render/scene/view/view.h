// How a scene is looked at: all of its tables that does not depend on what is in it.
#pragma once

#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "render/accel/ray_query.h"
#include "render/film/pixel_filter.h"
#include "render/integrator/scene_tables.h"
#include "render/scene/blob_source.h"
#include "render/scene/placement/render_space.h"
#include "render/scene/values/fault_list.h"
#include "render/scene/view/sensor.h"
#include "render/scene/view/settings.h"
#include "tessera/v1/job.pb.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::render {

absl::StatusOr<PixelFilterRecord> build_filter(const v1::PixelFilter& filter);

/// The sensor that a camera is, but for its medium; absent, and `faults` has why, where there is none.
/// `place` is what the camera is called there. `blobs`: of the scene; without, apertures that are pictures
/// are round, and a camera with a distortion map is at fault.
std::optional<SensorRecord> check_camera(const v1::Camera& camera, const std::string& place,
                                         const v1::JobSpec& job, const Settings& settings,
                                         const RenderSpace& space, const BlobSource& blobs,
                                         FaultList& faults);

/// Factor of radiance on the film of such a camera, by the film and the job's words; 1, and
/// `faults` has why, where that is not possible.
float check_exposure(const v1::Scene& scene, const v1::Camera& camera, const std::string& place,
                     const v1::JobSpec& job, FaultList& faults);

/// Sets camera, film and sampler; leaves the arrays alone, and the medium of the camera, which is one of
/// them.
absl::Status set_view(const v1::Scene& scene, const v1::JobSpec& job, const Settings& settings,
                      const RenderSpace& space, const BlobSource& blobs, SceneTables& tables);
/// The same, but goes on after a fault.
void set_view(const v1::Scene& scene, const v1::JobSpec& job, const Settings& settings,
              const RenderSpace& space, const BlobSource& blobs, SceneTables& tables, FaultList& faults);

/// Sets the sensor of the tables anew where the camera has a focus_point, for content that has its view.
/// InvalidArgument where nothing is hit there.
absl::Status focus_view(const v1::Scene& scene, const v1::JobSpec& job, const BlobSource& blobs,
                        const SceneArrays& arrays, const RayQuery& rays, SceneTables& tables);

}  // namespace tessera::render
