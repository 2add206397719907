// A scene file imported and loaded into the renderer, for tests and benchmarks that need no farm.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "render/renderer.h"
#include "tessera/v1/job.pb.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::test {

/// Settings that a test asks for, over those of the scene.
struct SceneJob {
  v1::RenderSettings settings;
  std::uint32_t width = 0, height = 0;  // pixels; 0: the scene's
  std::vector<v1::AOV> aovs;
};

struct LoadedFile {
  v1::JobSpec job;
  std::unique_ptr<render::RenderScene> scene;
};

/// `edit` may change the imported scene first.
absl::StatusOr<LoadedFile> load_scene_file(const std::string& path, const SceneJob& job,
                                           const std::string& isa, int threads,
                                           const std::function<void(v1::Scene&)>& edit = {});

/// Bytes of blobs by the names that stand for their digests.
using TestBlobs = std::map<std::string, std::string>;

/// A scene given as text (a v1::Scene in protobuf's text form).
absl::StatusOr<LoadedFile> load_scene_text(const std::string& text, const SceneJob& job,
                                           const std::string& isa, const TestBlobs& blobs = {});

/// Whether a warning tells what an algorithm is blind to (scene/light/unseen_light.h), which some tests are
/// about.
inline bool is_of_blindness(const std::string& warning) {
  return warning.find("' never finds the light of ") != std::string::npos ||
         warning.find("' does not see what is behind ") != std::string::npos;
}

}  // namespace tessera::test
