#include "local/scene_check.h"

#include "local/scene_blobs.h"
#include "render/scene/scene_faults.h"

namespace tessera::client {
namespace {

/// Faults as find(blobs) finds them, in the client's own form.
template <class Find>
std::vector<SceneFault> faults_of(const ImportedScene& imported, const Find& find) {
  std::vector<const SceneBlob*> blobs;
  for (const SceneBlob& blob : imported.blobs) blobs.push_back(&blob);
  const SceneBlobs source(blobs);
  std::vector<SceneFault> faults;
  for (render::SceneFault& fault : find([&](const std::string& digest) { return source.bytes(digest); }))
    faults.push_back({fault.element, std::move(fault.place), std::move(fault.message), fault.field});
  return faults;
}

}  // namespace

std::vector<SceneFault> find_scene_faults(const ImportedScene& imported, const v1::JobSpec* job) {
  return faults_of(imported, [&](const render::BlobSource& blobs) {
    return render::find_scene_faults(imported.scene, job, blobs, Diagnostics::kMaxErrors);
  });
}

std::vector<SceneFault> find_job_faults(const ImportedScene& imported, const v1::JobSpec& job) {
  return faults_of(imported, [&](const render::BlobSource& blobs) {
    return render::find_job_faults(imported.scene, job, blobs, Diagnostics::kMaxErrors);
  });
}

}  // namespace tessera::client
