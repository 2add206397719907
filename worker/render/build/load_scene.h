// Scene message -> RenderScene. The only place in the renderer that reads protobuf.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "render/renderer.h"

namespace tessera::v1 {
class Scene;
class JobSpec;
}  // namespace tessera::v1

namespace tessera::render {

/// The bytes of a blob; `owner` keeps them alive (a mapped file, a shared buffer). At least 16-byte aligned.
struct BlobBytes {
  std::string_view bytes;
  std::shared_ptr<const void> owner;
};

/// Where the scene's blobs come from, by digest. May block; called from several threads.
using BlobSource = std::function<absl::StatusOr<BlobBytes>(const std::string& digest)>;

struct LoadOptions {
  std::string isa;  // one of supported_isas()
  int threads = 1;  // for building
};

/// Builds everything that `job` needs of `scene`. InvalidArgument names the element that is at fault ("shape 12
/// (lamp): material 'x' does not exist"); errors of the blob source pass through.
absl::StatusOr<std::unique_ptr<RenderScene>> load_scene(const v1::Scene& scene, const v1::JobSpec& job,
                                                        const BlobSource& blobs, const LoadOptions& options);

}  // namespace tessera::render
