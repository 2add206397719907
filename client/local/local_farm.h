// A farm within this process: the coordinator and the worker of the big one, without
// messages between them.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "import/input/imported_scene.h"

namespace tessera::client {

struct BuiltScene;
class JobCalls;

struct LocalFarmOptions {
  int threads = 1;
  std::string isa;  // empty: the best of this machine
  std::vector<const SceneBlob*>
      blobs;  // all that the jobs will need; read in place, they must outlive the farm
  // Called, where there is one, when the scene has been read but for its images: the bytes of meshes may then
  // be freed, if there is one job alone.
  std::function<void()> geometry_read = {};
  // Folder for jobs and results; the next farm with the same goes on with them. Empty: they are kept in
  // memory.
  std::string checkpoint = {};
  bool web = false;  // serves the farm's web page on a free port of this machine, for as long as it lives
  // A scene that was built already, and may be that of a job; null: none was.
  std::shared_ptr<const BuiltScene> built = nullptr;
  // Called, where there is one, once, from another thread, when results cannot be kept any more: nothing
  // comes then.
  std::function<void(const absl::Status&)> failed = {};
};

/// The kernels that this machine can run, best first.
std::vector<std::string> local_isas();

class LocalFarm {
 public:
  /// FailedPrecondition when there are no kernels for this machine, or another process uses the checkpoint.
  static absl::StatusOr<std::unique_ptr<LocalFarm>> start(LocalFarmOptions options);

  /// Stops what is being rendered.
  ~LocalFarm();

  /// To the coordinator. Must not be used once the farm is gone.
  JobCalls& calls();

  /// Port of the web page; 0 when there is none.
  int web_port() const;

  /// Whether a scene is being built.
  bool building() const;
  /// Time spent building scenes so far, seconds.
  double build_seconds() const;

 private:
  struct Parts;
  explicit LocalFarm(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace tessera::client
