// Jobs whose pixels are readings of probes, here or on a farm.
#pragma once

#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "command/jobs/job_settings.h"
#include "farm/farm_client.h"
#include "image/image.h"
#include "import/input/imported_scene.h"
#include "measure/eye.h"
#include "measure/sampling.h"

namespace tessera::client {

struct BuiltScene;

struct ProbeJobOptions {
  JobSettings job = {};        // for all of them
  std::string name;            // of the jobs, for people
  int threads = 1;             // of a renderer of this process
  FarmClient* farm = nullptr;  // null: this process renders
  std::stop_token stop = {};
};

/// One scene, rendered through cameras of probes.
class ProbeJobs {
 public:
  /// `scene` must outlive this object, which changes its camera, film and settings.
  ProbeJobs(ImportedScene& scene, ProbeJobOptions options);
  ~ProbeJobs();

  /// Errors are those of jobs: InvalidArgument where the scene or its settings are at fault, Cancelled when
  /// stopped, others of the farm.
  absl::StatusOr<ProbePicture> render(const ProbeJob& job);
  /// The luminances of the pixels of a picture. Errors as of render().
  absl::StatusOr<std::vector<double>> render(const PictureJob& job);
  /// Takes all lights from the scene, also those of its shapes, for good; this one with the map `sky` takes
  /// their place. Errors as of render().
  absl::StatusOr<ProbePicture> render(const ProbeJob& job, const v1::Light& light, std::string sky);

  /// The next job builds the scene anew: its lights were changed. What else it holds is kept.
  void forget_scene() { built_.reset(); }

  /// Warnings of the jobs so far, each once.
  const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  /// Renders the scene as it is, with these settings.
  absl::StatusOr<Image> run(const v1::RenderSettings& settings);
  absl::StatusOr<Image> run(const PreparedJob& job);
  absl::Status check(const v1::JobSpec& spec);
  absl::Status build(const PreparedJob& job);
  void add_blobs(const std::vector<SceneBlob>& blobs);
  void warn(const std::string& warning);

  ImportedScene& scene_;
  ProbeJobOptions options_;
  std::shared_ptr<const BuiltScene> built_;  // the scene as it was built for the first job of this process
  std::vector<std::string> warnings_;
  bool checked_ = false, has_patch_ = false;
  double cpu_seconds_ = 0;  // of the latest job
};

/// The ball around the box around all shapes of the scene, and its lights at places.
absl::StatusOr<Ball> ball_around(const ImportedScene& scene, int threads);

}  // namespace tessera::client
