#include "command/jobs/follow.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <iostream>
#include <optional>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "base/available_memory.h"
#include "base/printable.h"
#include "command/exit_code.h"
#include "command/jobs/job_news.h"
#include "command/report/choice_text.h"
#include "command/report/file_facts.h"
#include "command/report/output.h"
#include "command/report/progress.h"
#include "denoise/denoise.h"
#include "image/assemble.h"
#include "image/exr/rows.h"
#include "wire/aov_channels.h"
#include "wire/enum_words.h"
#include "wire/job_check.h"
#include "wire/version.h"

namespace tessera::client {
namespace {

using Clock = std::chrono::steady_clock;

AssemblyOptions assembly_options(const v1::JobSpec& spec) {
  AssemblyOptions options;
  options.width = spec.view().width();
  options.height = spec.view().height();
  options.crop = crop_of(spec);
  options.spp = spec.samples().spp();
  options.overscan = spec.farm().overscan();
  options.tile_size = wire::works_in_passes(spec) ? 0 : spec.cut().tile_size();
  options.channels = wire::channels_of(spec.view());
  options.samples_channel =
      std::ranges::find(spec.view().aovs(), v1::AOV_SAMPLES) != spec.view().aovs().end();
  return options;
}

std::uint64_t samples_of(const v1::JobSpec& spec) {
  const v1::PixelRect& crop = spec.cut().crop();
  return std::uint64_t{crop.x1() - crop.x0()} * (crop.y1() - crop.y0()) * spec.samples().spp();
}

/// Progress of one job, and what happens to it, on stderr.
class Tale {
 public:
  Tale(const v1::JobSpec& spec, const FollowOptions& options)
      : options_(options),
        // The noise decides how many samples are taken.
        samples_total_(spec.samples().noise() == 0 ? samples_of(spec) : 0),
        progress_(progress_mode(STDERR_FILENO, options.quiet), std::cerr, base::printable(spec.farm().name()),
                  samples_total_, Clock::now(), terminal_columns(STDERR_FILENO)) {}

  /// `received`: samples whose results are here; absent where results are not asked for.
  void tell(const v1::JobStatus& status, std::optional<std::uint64_t> received) {
    if (!options_.quiet) {
      for (const std::string& line : news_.lines(status)) {
        progress_.clear();
        std::cerr << "tessera: " << line << std::endl;
      }
    }
    const double units = static_cast<double>(status.units_done()) / std::max(status.units_total(), 1u);
    const auto total = static_cast<double>(samples_total_);
    WorkDone done{units, static_cast<std::uint64_t>(units * total)};
    if (samples_total_ == 0) done.samples = status.stats().samples();
    if (samples_total_ > 0 && received) done = {static_cast<double>(*received) / total, *received};
    progress_.update(done, Clock::now(), waits_for(status));
  }
  void end() { progress_.finish(Clock::now()); }

 private:
  /// The phase before the first result.
  std::string waits_for(const v1::JobStatus& status) const {
    if (status.paused()) return "paused";
    if (options_.building)
      return options_.building() ? "building the scene" : "starting, or rendering the first tiles";
    if (status.units_leased() == 0) {
      const std::string why = base::printable(status.waiting_for());
      return why.empty() ? "waiting for a worker" : absl::StrCat("waiting: ", why);
    }
    if (!status.phase().empty()) return absl::StrCat("phase ", base::printable(status.phase()));
    return absl::StrCat("building the scene, or rendering the first tiles, on ", status.workers(),
                        status.workers() == 1 ? " worker" : " workers");
  }

  const FollowOptions options_;
  const std::uint64_t samples_total_;
  Progress progress_;
  JobNews news_;
};

/// Hands the result to whoever looks on, and to the assembler where there is one.
absl::Status add_result(const v1::UnitResult& unit, const FollowOptions& how, Assembler* assembler) {
  absl::StatusOr<wire::TileResult> result = wire::decode_tile_result(unit.payload());
  if (result.ok() && how.show) how.show(*result);
  absl::Status status = result.status();
  if (status.ok() && assembler != nullptr) status = assembler->add(*std::move(result));
  if (status.ok()) return status;
  return absl::InternalError(absl::StrCat("result of unit ", unit.unit().index(), ": ", status.message()));
}

double seconds(const google::protobuf::Duration& duration) {
  return static_cast<double>(duration.seconds()) + 1e-9 * duration.nanos();
}

/// "x0,y0,x1,y1 empty; x0,y0,x1,y1 partial", in pixels of the film.
std::string list_of(const std::vector<Hole>& holes) {
  std::string list;
  for (const Hole& hole : holes) {
    absl::StrAppend(&list, list.empty() ? "" : "; ", hole.pixels.x0, ",", hole.pixels.y0, ",", hole.pixels.x1,
                    ",", hole.pixels.y1, hole.empty ? " empty" : " partial");
  }
  return list;
}

RenderInfo render_info(const v1::JobSpec& spec, const v1::JobStatus& status) {
  RenderInfo info;
  info.scene_digest = spec.content().scene();
  info.spp = spec.samples().spp();
  info.seed = spec.view().seed();
  info.integrator = spec.content().algorithms().integrator();
  info.integrator_kind = wire::kind_of(spec.content().algorithms());
  info.choice = base::printable(choice_in_one_line(spec));
  info.sampler = wire::word_of(spec.view().sampler());
  info.isa = status.isa();
  info.arithmetic = {status.arithmetic_classes().begin(), status.arithmetic_classes().end()};
  info.version = wire::build_version();
  info.render_seconds = seconds(status.stats().cpu_time());
  return info;
}

}  // namespace

Window crop_of(const v1::JobSpec& spec) {
  const v1::PixelRect& crop = spec.cut().crop();
  return {static_cast<std::int32_t>(crop.x0()), static_cast<std::int32_t>(crop.y0()),
          static_cast<std::int32_t>(crop.x1()), static_cast<std::int32_t>(crop.y1())};
}

absl::StatusOr<FollowedJob> follow_job(JobCalls& farm, const std::string& job_id, const v1::JobSpec& spec,
                                       const FollowOptions& how, std::stop_token stop,
                                       const PartialImage& partial) {
  AssemblyOptions options = assembly_options(spec);
  options.max_frame_bytes = how.frame_memory;
  options.mattes = how.mattes;
  absl::StatusOr<Assembler> assembler = Assembler::create(options);
  if (!assembler.ok()) return assembler.status();

  const Clock::time_point start = Clock::now();
  Tale tale{spec, how};
  FollowedJob followed;
  std::uint32_t units = 0;
  std::stop_source enough;
  const std::stop_callback stopped{stop, [&] { enough.request_stop(); }};
  JobCalls::WatchHandlers handlers;
  handlers.result = [&](const v1::UnitResult& unit) {
    ++units;
    return add_result(unit, how, &*assembler);
  };
  handlers.status = [&](const v1::JobStatus& status) {
    followed.status = status;
    tale.tell(status, assembler->samples_done());
    if (partial.units > 0 && units >= partial.units) enough.request_stop();
  };
  handlers.restart = [&]() -> absl::Status {
    units = 0;
    if (how.show_anew) how.show_anew();
    auto again = Assembler::create(options);
    if (!again.ok()) return again.status();
    assembler = std::move(again);
    return absl::OkStatus();
  };
  absl::StatusOr<v1::JobStatus> status = farm.watch(job_id, handlers, enough.get_token());
  tale.tell(status.ok() ? *status : followed.status, assembler->samples_done());
  tale.end();
  if (status.ok()) {
    followed.status = *std::move(status);
  } else if (!partial.wanted) {
    return status.status();
  } else if (stop.stop_requested() || !enough.stop_requested()) {
    followed.broken_off = status.status();
  }

  const bool over = followed.status.state() == v1::DONE || followed.status.state() == v1::INCOMPLETE;
  if (over || (partial.wanted && assembler->samples_done() > 0)) {
    absl::StatusOr<Assembly> assembly = std::move(*assembler).finish();
    if (!assembly.ok()) return assembly.status();
    followed.image = std::move(assembly->image);
    followed.rows = std::move(assembly->rows);
    followed.incomplete_pixels = assembly->incomplete_pixels;
    followed.holes = std::move(assembly->holes);
  }
  followed.wall_seconds = std::chrono::duration<double>(Clock::now() - start).count();
  return followed;
}

absl::StatusOr<v1::JobStatus> follow_progress(FarmClient& farm, const std::string& job_id,
                                              const v1::JobSpec& spec, const FollowOptions& how,
                                              std::stop_token stop) {
  Tale tale{spec, how};
  FarmClient::WatchHandlers handlers;
  handlers.status = [&](const v1::JobStatus& status) { tale.tell(status, std::nullopt); };
  if (how.show) {
    handlers.result = [&](const v1::UnitResult& unit) { return add_result(unit, how, nullptr); };
    handlers.restart = [&] {
      if (how.show_anew) how.show_anew();
      return absl::OkStatus();
    };
  }
  absl::StatusOr<v1::JobStatus> status = farm.watch(job_id, handlers, stop);
  tale.end();
  return status;
}

int report_end(const v1::JobStatus& status) {
  if (status.state() == v1::DONE) return kDone;
  if (status.state() == v1::CANCELLED)
    return report(kJobFailed, absl::StrCat("job ", status.job_id(), " was cancelled"));
  if (status.state() == v1::INCOMPLETE) {
    return report(kHoles, absl::StrCat("job ", status.job_id(), " is incomplete: ", status.error(),
                                       "\ntry again with: tessera retry ", status.job_id()));
  }
  return report(kJobFailed, absl::StrCat("job ", status.job_id(), " failed: ", status.error()));
}

namespace {

/// The exit code, with a message where the job, or following it, did not end well.
int end_of(const FollowedJob& followed) {
  const v1::JobStatus& status = followed.status;
  if (!followed.broken_off.ok()) {
    const int code = report_farm_error(followed.broken_off);
    if (!followed.image)
      return report(static_cast<ExitCode>(code), "nothing was rendered, so no image is written");
    return report(static_cast<ExitCode>(code),
                  absl::StrCat("the image is a partial one: ", status.units_done(), " of ",
                               status.units_total(), " units"));
  }
  return has_ended(status.state()) ? report_end(status) : kDone;
}

}  // namespace

std::uint64_t frame_memory(const ExrFormat& exr, std::uint64_t denoising) {
  const std::uint64_t available = base::available_memory();
  if (denoising > 0 && denoising <= available) return UINT64_MAX;
  constexpr std::uint64_t kMost = std::uint64_t{1} << 30;
  return exr.frame_memory ? *exr.frame_memory : std::min(kMost, available / 4);
}

int deliver(FollowedJob& followed, const v1::JobSpec& spec, const std::string& output, const ExrFormat& exr,
            bool quiet) {
  if (!quiet) {
    for (const std::string& warning : followed.status.stats().warnings())
      std::cerr << "warning: " << base::printable(warning) << '\n';
  }
  const int code = end_of(followed);
  if (!followed.image) return code;
  set_render_info(render_info(spec, followed.status), *followed.image);
  add_file_facts(spec.farm().name(), std::time(nullptr), *followed.image);
  mark_biased(*followed.image);
  if (followed.status.state() != v1::DONE && followed.incomplete_pixels > 0) {
    followed.image->metadata["tessera.partial"] =
        absl::StrCat(followed.status.units_done(), " of ", followed.status.units_total(), " units");
  }
  const auto& warnings = followed.status.stats().warnings();
  if (!warnings.empty()) {
    const std::set<std::string> sorted(warnings.begin(), warnings.end());
    followed.image->metadata["tessera.warnings"] = absl::StrJoin(sorted, "\n");
  }
  if (!followed.holes.empty()) followed.image->metadata["tessera.holes"] = list_of(followed.holes);
  const absl::Status status = followed.rows ? write_image(*followed.image, *followed.rows, output, exr)
                                            : write_image(*followed.image, output, exr);
  if (!status.ok()) {
    return report(kIncomplete, std::string{status.message()});
  }
  followed.written = true;
  if (code == kDone && followed.incomplete_pixels > 0) {
    return report(kIncomplete, absl::StrCat(followed.incomplete_pixels, " pixels lack samples"));
  }
  if (code == kDone && !followed.denoised.ok()) {
    return report(
        kNotDenoised,
        absl::StrCat(output, " is as it was rendered, not denoised: ", followed.denoised.message()));
  }
  return code;
}

}  // namespace tessera::client
