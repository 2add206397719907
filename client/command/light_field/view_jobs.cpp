#include "command/light_field/view_jobs.h"

#include <cmath>
#include <iostream>
#include <limits>
#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "base/printable.h"
#include "command/exit_code.h"
#include "command/jobs/follow.h"
#include "command/jobs/go_on.h"
#include "command/render_options.h"
#include "command/report/film_facts.h"
#include "local/checkpoint.h"
#include "local/geometry_query.h"
#include "local/local_farm.h"
#include "local/scene_check.h"

namespace tessera::client {
namespace {

absl::Status check_view_job(const ImportedScene& scene, const v1::JobSpec& spec) {
  std::vector<SceneFault> faults = find_scene_faults(scene, &spec);
  for (SceneFault& fault : find_job_faults(scene, spec)) faults.push_back(std::move(fault));
  return faults.empty() ? absl::OkStatus() : status_of(faults, scene);
}

/// The number in a column of a row of bounds; NaN where there is none.
double bound_in(const Row& row, std::string_view column) {
  const Columns columns = GeometryQuery::bounds_columns();
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (columns[i] != column) continue;
    if (const auto* const number = std::get_if<double>(&row[i])) return *number;
    if (const auto* const whole = std::get_if<std::int64_t>(&row[i])) return static_cast<double>(*whole);
  }
  return std::numeric_limits<double>::quiet_NaN();
}

std::string bounds_name(const Row& row) {
  const Columns columns = GeometryQuery::bounds_columns();
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (columns[i] != std::string_view("name")) continue;
    if (const auto* const text = std::get_if<std::string_view>(&row[i])) return std::string(*text);
  }
  const double shape = bound_in(row, "shape"), instance = bound_in(row, "instance");
  return std::isnan(shape) ? absl::StrCat("instance ", instance) : absl::StrCat("shape ", shape);
}

absl::StatusOr<FollowedJob> follow_views(JobCalls& calls, const PreparedJob& job,
                                         const ViewJobOptions& options, std::function<bool()> building) {
  const bool here = options.farm == nullptr;
  const auto id =
      here ? submit_or_go_on(calls, job.spec, options.stop) : calls.submit(job.spec, {}, options.stop);
  if (!id.ok()) return id.status();
  FollowOptions how;
  how.quiet = options.quiet;
  how.building = std::move(building);
  return follow_job(calls, *id, job.spec, how, options.stop);
}

absl::StatusOr<FollowedJob> run_views(PreparedJob& job, const ViewJobOptions& options) {
  if (options.farm != nullptr) {
    const auto uploaded = options.farm->upload(job.blobs, options.stop, {});
    if (!uploaded.ok()) return uploaded.status();
    return follow_views(*options.farm, job, options, {});
  }
  if (!options.checkpoint.empty()) {
    if (absl::Status s = open_checkpoint(options.checkpoint); !s.ok()) return s;
  }
  set_local_isa(job.spec);
  const auto local = LocalFarm::start({.threads = options.threads,
                                       .isa = job.spec.farm().isa(),
                                       .blobs = job.blobs,
                                       .checkpoint = options.checkpoint});
  if (!local.ok()) return local.status();
  return follow_views((*local)->calls(), job, options, [&farm = **local] { return farm.building(); });
}

}  // namespace

void drop_picture_settings(ImportedScene& scene) {
  v1::RenderSettings& own = *scene.scene.mutable_settings();
  own.clear_noise(), own.clear_layers(), own.clear_film();
}

absl::StatusOr<std::unique_ptr<PreparedJob>> prepare_views(const ImportedScene& scene,
                                                           const ViewJobOptions& options) {
  JobSettings asked = options.job;
  asked.aovs = {v1::AOV_ALPHA, v1::AOV_DEPTH};
  auto job = prepare_job(asked, scene, options.name);
  if (!job.ok()) return absl::InvalidArgumentError(job.status().message());
  if (absl::Status s = check_view_job(scene, (*job)->spec); !s.ok()) return s;
  return job;
}

absl::StatusOr<std::vector<Image>> render_views(PreparedJob& job, const ViewJobOptions& options) {
  auto followed = run_views(job, options);
  if (!followed.ok()) return followed.status();
  const v1::JobStatus& status = followed->status;
  if (!options.quiet) {
    for (const std::string& warning : status.stats().warnings())
      std::cerr << "warning: " << base::printable(warning) << '\n';
  }
  if (status.state() != v1::DONE) {
    const std::string& why = status.error();
    return absl::AbortedError(absl::StrCat("job ", status.job_id(), " was not finished",
                                           why.empty() ? "" : absl::StrCat(": ", why)));
  }
  std::vector<Image> images;
  for (FollowedImage& of_view : followed->images) {
    if (of_view.incomplete_pixels > 0 || of_view.rows != nullptr)
      return absl::AbortedError(absl::StrCat("view ", images.size(), " lacks samples"));
    add_film_facts(job.spec, of_view.image);
    images.push_back(std::move(of_view.image));
  }
  return images;
}

absl::StatusOr<SceneBounds> bounds_of_scene(const PreparedJob& job, int threads) {
  v1::JobSpec spec = job.spec;
  set_local_isa(spec);
  GeometryOptions how;
  how.threads = threads;
  const auto query = GeometryQuery::load(spec, job.blobs, how);
  if (!query.ok()) return query.status();
  SceneBounds bounds;
  bool is_first = true;
  (*query)->bounds([&](const Row& row) {
    const Imath::V3d low(bound_in(row, "low_x"), bound_in(row, "low_y"), bound_in(row, "low_z"));
    const Imath::V3d high(bound_in(row, "high_x"), bound_in(row, "high_y"), bound_in(row, "high_z"));
    const bool is_scene = std::exchange(is_first, false);
    if (std::isnan(low.x) || std::isnan(high.x)) return;
    const Imath::Box3d box(low, high);
    if (is_scene) {
      bounds.all = box;
    } else {
      bounds.shapes.emplace_back(bounds_name(row), box);
    }
  });
  return bounds;
}

int report_view_error(const absl::Status& status) {
  const std::string message(status.message());
  if (absl::IsInvalidArgument(status)) return report(kBadScene, message);
  if (absl::IsAborted(status)) return report(kJobFailed, message);
  return report_farm_error(status);
}

}  // namespace tessera::client
