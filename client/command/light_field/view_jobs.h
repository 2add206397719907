// Jobs whose views are those of a light field, here or on a farm.
#pragma once

#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "capture/plan.h"
#include "command/jobs/job_settings.h"
#include "farm/farm_client.h"
#include "image/image.h"
#include "import/input/imported_scene.h"

namespace tessera::client {

struct ViewJobOptions {
  JobSettings job = {};        // the size of views is its resolution
  std::string name;            // for people
  int threads = 1;             // of a renderer of this process
  FarmClient* farm = nullptr;  // null: this process renders
  std::string checkpoint;      // a folder; empty: results are kept in memory
  bool quiet = false;
  std::stop_token stop = {};
};

/// Takes from the scene the settings that are those of single pictures.
void drop_picture_settings(ImportedScene& scene);

/// The job of all views of the scene, whose cameras were set: colour, alpha and depth. InvalidArgument, with
/// the place, where the scene or the settings are at fault. `scene` outlives the result.
absl::StatusOr<std::unique_ptr<PreparedJob>> prepare_views(const ImportedScene& scene,
                                                           const ViewJobOptions& options);

/// Renders them: a picture a view. Cancelled where it was stopped, Aborted where the job was not finished;
/// others are those of the farm.
absl::StatusOr<std::vector<Image>> render_views(PreparedJob& job, const ViewJobOptions& options);

/// Boxes about the scene and its shapes.
absl::StatusOr<SceneBounds> bounds_of_scene(const PreparedJob& job, int threads);

/// The exit code of an error of these, with a message.
int report_view_error(const absl::Status& status);

}  // namespace tessera::client
