// A scene file imported and loaded into the renderer, for tests and benchmarks that need no farm.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "render/renderer.h"
#include "tessera/v1/job.pb.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::test {

struct LoadedFile {
  v1::JobSpec job;
  std::unique_ptr<render::RenderScene> scene;
};

/// Where `job` leaves a field at zero, the scene's own settings hold. `edit` may change the imported scene
/// first.
absl::StatusOr<LoadedFile> load_scene_file(const std::string& path, v1::JobSpec job, const std::string& isa,
                                           int threads, const std::function<void(v1::Scene&)>& edit = {});

/// Bytes of blobs by the names that stand for their digests.
using TestBlobs = std::map<std::string, std::string>;

/// A scene given as text (a v1::Scene in protobuf's text form).
absl::StatusOr<LoadedFile> load_scene_text(const std::string& text, v1::JobSpec job, const std::string& isa,
                                           const TestBlobs& blobs = {});

}  // namespace tessera::test
