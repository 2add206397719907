#include "local/shape_check.h"

#include "local/scene_blobs.h"
#include "render/build/shape/shape_faults.h"

namespace tessera::client {

std::vector<SceneFault> find_shape_faults(const ImportedScene& imported) {
  std::vector<const SceneBlob*> blobs;
  for (const SceneBlob& blob : imported.blobs) blobs.push_back(&blob);
  const SceneBlobs source(blobs);
  std::vector<SceneFault> faults;
  for (render::ShapeFault& fault : render::find_shape_faults(
           imported.scene, [&](const std::string& digest) { return source.bytes(digest); },
           Diagnostics::kMaxErrors))
    faults.push_back({fault.shape, std::move(fault.place), std::move(fault.message)});
  return faults;
}

}  // namespace tessera::client
