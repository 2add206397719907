// `--integrator auto`: which integrator renders a job with the least error times time?
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "absl/status/statusor.h"
#include "command/jobs/job_settings.h"
#include "import/input/imported_scene.h"
#include "local/bench_scene.h"
#include "tessera/v1/job.pb.h"

namespace tessera::client {

/// The integrator's name that asks for a choice. No job has it.
inline constexpr const char* kAutoIntegrator = "auto";

/// Whether the command line, or the scene where that names none, leaves the integrator to a choice.
bool asks_for_choice(const JobSettings& request, const v1::Scene& scene);

struct ChoiceOptions {
  int threads = 1;
  bool keeps_scene = false;  // the job's scene is that of ChosenJob: building it is no cost of the pilot
  /// Part of the job's time.
  double scene_read_cpu_seconds = 0;
  std::function<std::stop_token()> stop = [] { return std::stop_token{}; };  // asked when a pilot begins
  /// CPU seconds of a pixel's sample by this integrator, in place of measured ones: the choice is then a
  /// function of the job, with one thread to the bit. Building a scene takes none.
  std::function<double(const std::string& integrator)> sample_cpu_seconds = {};
  /// Jobs whose choice is taken over without a pilot: one that this job continues, and one that was begun and
  /// counts if it is the same.
  std::optional<v1::JobSpec> continued = {}, begun = {};
};

/// A job with the integrator that was chosen for it.
struct ChosenJob {
  std::unique_ptr<PreparedJob> job;
  std::shared_ptr<const BuiltScene> built = nullptr;  // its scene, where the pilot has built it
};

/// Prepares the job (job_settings.h) with the integrator that a pilot in this process chooses (pilot/pilot.h)
/// among `path` (`volpath` where there are media), `bdpt`, `vcm` and `light`, and keeps how it came to that
/// in the job's farm.auto_choice. Integrators with which the settings do not go, or that cannot render the
/// scene, are left out by name; where none is left, the first one's error is returned. Cancelled when
/// stopped.
absl::StatusOr<ChosenJob> choose_job(const JobSettings& request, const ImportedScene& scene,
                                     const std::string& name, const ChoiceOptions& options);

}  // namespace tessera::client
