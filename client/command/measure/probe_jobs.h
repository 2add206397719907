// Jobs whose pixels are readings of probes, here or on a farm.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <set>
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

namespace tessera::render {
class SharedContents;
}

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
  void forget_scene() { built_.clear(); }

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
  // The scene as it was built in this process for the first job of each integrator; they share what they have
  // in common.
  std::map<std::string, std::shared_ptr<const BuiltScene>> built_;
  std::shared_ptr<render::SharedContents> contents_;
  std::set<std::string> checked_;  // integrators of which a job was checked
  std::vector<std::string> warnings_;
  bool has_patch_ = false;
  double cpu_seconds_ = 0;  // of the latest job
  std::uint64_t rays_ = 0;  // that it traced
};

/// The flux that the lights of `lights` emit, a part of the scene with its blobs: a luminance flux, in the
/// scene's radiance and unit of length squared, to 1e-4 where textures have no finer detail than some hundred
/// steps across. InvalidArgument where such a scene cannot be built.
absl::StatusOr<double> emitted_flux(const ImportedScene& scene, const v1::Scene& lights, int threads);

/// The ball around the box around all shapes of the scene, and its lights at places.
absl::StatusOr<Ball> ball_around(const ImportedScene& scene, int threads);

}  // namespace tessera::client
