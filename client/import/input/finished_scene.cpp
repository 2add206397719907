#include "import/input/finished_scene.h"

#include <utility>

#include "import/input/instance_list.h"
#include "import/input/valid_text.h"

namespace tessera::client {

ImportedScene finished_scene(v1::Scene scene, std::string name, BlobCollector blobs,
                             const Diagnostics& diagnostics) {
  pack_instances(scene, blobs);
  ImportedScene result{.scene = std::move(scene), .blobs = blobs.take(), .warnings = diagnostics.warnings()};
  result.scene.set_name(std::move(name));
  make_text_valid(result.scene);
  for (SceneBlob& blob : result.blobs) make_text_valid(blob.ref);
  return result;
}

}  // namespace tessera::client
