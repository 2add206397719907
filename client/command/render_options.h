// The options that `render` and `submit` share.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "command/command_line.h"
#include "command/frames/frame_list.h"
#include "command/jobs/auto_choice.h"
#include "command/jobs/follow.h"
#include "command/jobs/job_settings.h"
#include "command/report/output.h"
#include "image/cryptomatte.h"
#include "import/gltf/gltf_options.h"
#include "import/import.h"

namespace tessera::client {

/// An animation; no frames: one image.
struct FrameOptions {
  std::vector<std::int64_t> frames;
  FrameOrder order = FrameOrder::kForward;
  std::optional<Rational> rate;  // frames a second
  // The scene's own: load_job() puts it there, where there is room for it.
  std::shared_ptr<std::optional<Rational>> scene_rate = nullptr;
  bool skip_existing = false;
  std::string preview_video;  // a file; empty: none
};

struct RenderOptions {
  std::string scene;   // the file
  std::string output;  // .exr or .png
  JobSettings job;
  std::vector<std::string> defines;  // NAME=VALUE
  GltfOptions gltf = {};
  /// How all implicit surfaces find roots; none: as the scene says.
  std::optional<v1::ImplicitSurface::Roots> roots;
  int threads = 0;  // threads of this process
  ExrFormat exr;
  std::string stats;       // a JSON file; empty: none
  std::string checkpoint;  // a folder; empty: none. `render` only
  std::string display;     // "web", "tev": where the picture is shown; empty: nowhere. `render` only
  bool quiet = false;
  FrameOptions frames;
  std::optional<std::int64_t> frame;  // the one of the animation that is to be rendered
  std::string group;                  // group of the animation's jobs
  /// World space: Scene.render_origin of scenes that have none. Null: theirs to choose. Where it has no
  /// value, load_job() puts the place of the scene's camera there.
  std::shared_ptr<std::optional<v1::Point3>> origin = nullptr;
};

/// Defines the options on `command`. Values that make no sense are refused while the command line is parsed.
void define_render_options(options::Command& command, RenderOptions& options);

/// Adds the options that say how a scene is rendered. `bench` has them too, with a --spp of its own.
void define_job_options(options::Command& command, RenderOptions& options, bool with_samples = true);

/// How the scene is to be read.
ImportOptions import_options(const RenderOptions& options);

/// Frames a second: as asked for, or of the scene's own animation, or 24.
Rational frame_rate(const RenderOptions& options, const v1::Scene& scene);

/// InvalidArgument when the file of --stats cannot be written.
absl::Status check_stats(const RenderOptions& options);

/// An imported scene and the job made of it.
struct LoadedJob {
  ImportedScene imported;
  std::unique_ptr<PreparedJob> job;
  std::shared_ptr<const BuiltScene> built = nullptr;  // the job's scene, where it was built already
  double import_seconds = 0;                          // digests included
  double import_cpu_seconds = 0;
  Rational rate;       // frames a second of an animation
  double shutter = 0;  // share of a frame of it for which the shutter is open

  /// Frees the bytes of meshes and packed instances.
  void free_meshes();
  /// Frees those of all blobs, which the job does not know any more.
  void free_blobs();
  /// Adds to the job's images what their files tell of scene and frame.
  void describe(const RenderOptions& options, FollowedJob& followed) const;
  /// The Cryptomattes of its pictures, with names of the scene, which must outlive them.
  std::vector<MatteList> mattes(const RenderOptions& options) const;
  /// "file:line:column: message", one a warning.
  std::vector<std::string> warning_lines() const;
};

/// Imports the scene, prints its warnings (unless quiet) and prepares the job. Null, with the message printed
/// and the exit code set, when that cannot be done. With `refusal`, a job that the settings do not go with
/// puts its message there instead. Integrator "auto" is for those that say how to choose one.
std::unique_ptr<LoadedJob> load_job(const RenderOptions& options, int& exit_code,
                                    absl::Status* refusal = nullptr, const ChoiceOptions* choice = nullptr);

/// Names the best kernels of this machine, where the job names none.
void set_local_isa(v1::JobSpec& spec);

/// Builds the job's scene in this process, by the best kernels where it names none, and prints its warnings
/// (unless quiet). Errors as BenchScene::load.
absl::StatusOr<std::unique_ptr<BenchScene>> build_scene(LoadedJob& loaded, const RenderOptions& options);

}  // namespace tessera::client
