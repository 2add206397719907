// Scene message -> RenderScene. The only place in the renderer that reads protobuf.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>

#include "absl/status/statusor.h"
#include "render/renderer.h"
#include "render/scene/blob_source.h"
#include "render/scene/texture/shared_images.h"

namespace tessera::v1 {
class Scene;
class JobSpec;
}  // namespace tessera::v1

namespace tessera::render {

/// Contents that scenes loaded at a time share, for load_scene(): it finds there what it need
/// not build again. Holds nothing alive. Thread-safe.
class SharedContents {
 public:
  /// Null when there is nothing with that key.
  std::shared_ptr<const void> find(const std::string& key) {
    std::lock_guard lock{mutex_};
    const auto found = contents_.find(key);
    std::shared_ptr<const void> content = found == contents_.end() ? nullptr : found->second.lock();
    if (content) ++shared_;
    return content;
  }
  void add(const std::string& key, const std::shared_ptr<const void>& content) {
    std::lock_guard lock{mutex_};
    std::erase_if(contents_, [](const auto& entry) { return entry.second.expired(); });
    contents_[key] = content;
  }
  /// How often find() found something.
  std::uint64_t shared() const {
    std::lock_guard lock{mutex_};
    return shared_;
  }
  /// Images of contents that are not the same as a whole.
  SharedImages& images() { return images_; }

 private:
  mutable std::mutex mutex_;
  std::map<std::string, std::weak_ptr<const void>> contents_;
  std::uint64_t shared_ = 0;
  SharedImages images_;
};

struct LoadOptions {
  std::string isa;                     // an entry of supported_isas()
  int threads = 1;                     // threads that build
  SharedContents* contents = nullptr;  // shared by the scenes loaded before, where there may be any
  // Called, where there is one, when the tables are filled: before the BVH is built, the moment of most
  // memory. Of the blobs only images are read from then on.
  std::function<void()> geometry_read = {};
  // Who goes over all instances, so that objects within objects are flattened, for messages; empty: only the
  // integrator, where it does.
  std::string lists_instances = "";
  std::stop_token stop = {};
};

/// Builds everything that `job` needs of `scene`; what it has in common with a scene that is loaded (all but
/// the film, the sampler, the depth of paths and, where it stands still, the camera's direction and lens, and
/// its place if the scene has a render_origin) is shared with that. InvalidArgument names the element that is
/// at fault ("shape 12 (lamp): material 'x' does not exist"); errors of the blob source pass through.
/// Cancelled once a stop is requested: within what a pass over all primitives takes.
absl::StatusOr<std::unique_ptr<RenderScene>> load_scene(const v1::Scene& scene, const v1::JobSpec& job,
                                                        const BlobSource& blobs, const LoadOptions& options);

}  // namespace tessera::render
