// Finds all faults of a scene at once, without building it: for clients, before they submit. They are found
// by the builders themselves, whose errors of load_scene() these are.
#pragma once

#include <cstddef>
#include <vector>

#include "render/scene/blob_source.h"
#include "render/scene/values/fault_list.h"
#include "tessera/v1/job.pb.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::render {

/// Faults of textures, media, materials, shapes, objects, instances and lights, in this order; `most` of them
/// at most. `job` says whether media are seen and how textures are filtered; null: they are, as usual.
///
/// Image files are read by their headers, and only those that something looks up; meshes where they have
/// attributes that are looked up or are operands; grids of densities as a whole. Faults that only a scene
/// that is built can tell are not found: pixels that are damaged, and places beyond the range of floats but
/// for the world's plain instances.
std::vector<SceneFault> find_scene_faults(const v1::Scene& scene, const v1::JobSpec* job,
                                          const BlobSource& blobs, std::size_t most);

/// Things that the job cannot do with the scene: wire::find_obstacles(), faults of camera and film, and more
/// instances or triangles than its algorithm takes.
std::vector<SceneFault> find_job_faults(const v1::Scene& scene, const v1::JobSpec& job,
                                        const BlobSource& blobs, std::size_t most);

}  // namespace tessera::render
