// Scene message -> the geometry that queries ask.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "render/query/query_scene.h"
#include "render/scene/blob_source.h"

namespace tessera::v1 {
class Scene;
class JobSpec;
}  // namespace tessera::v1

namespace tessera::render {

struct QueryOptions {
  std::string isa;  // an entry of supported_isas()
  float time = 0;   // 0 (the shutter opens) to 1
  int threads = 1;  // used for building
};

/// Adds to `warnings` what the scene asks for and is left out. Errors as of load_scene().
absl::StatusOr<std::unique_ptr<const QueryScene>> load_query(const v1::Scene& scene, const v1::JobSpec& job,
                                                             const BlobSource& blobs,
                                                             const QueryOptions& options,
                                                             std::vector<std::string>& warnings);

}  // namespace tessera::render
