#include "command/jobs/follow.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <filesystem>
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
#include "command/report/film_facts.h"
#include "command/report/output.h"
#include "command/report/progress.h"
#include "denoise/denoise.h"
#include "image/assemble.h"
#include "image/exr/rows.h"
#include "wire/aov_channels.h"
#include "wire/enum_words.h"
#include "wire/job_check.h"
#include "wire/scene_views.h"
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
  return std::uint64_t{crop.x1() - crop.x0()} * (crop.y1() - crop.y0()) * spec.samples().spp() *
         wire::views_of(spec);
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

/// Puts the pictures of a job's views together.
class Pictures {
 public:
  static absl::StatusOr<Pictures> begin(const v1::JobSpec& spec, const FollowOptions& how) {
    const std::uint32_t views = wire::views_of(spec);
    AssemblyOptions options = assembly_options(spec);
    options.max_frame_bytes = how.frame_memory / views;
    options.mattes = how.mattes;
    Pictures pictures;
    for (std::uint32_t view = 0; view < views; ++view) {
      absl::StatusOr<Assembler> assembler = Assembler::create(options);
      if (!assembler.ok()) return assembler.status();
      pictures.assemblers_.push_back(*std::move(assembler));
    }
    return pictures;
  }

  absl::Status add(std::uint32_t view, wire::TileResult result) {
    if (view >= assemblers_.size())
      return absl::InvalidArgumentError(absl::StrCat("the job has no view ", view));
    return assemblers_[view].add(std::move(result));
  }

  std::uint64_t samples_done() const {
    std::uint64_t samples = 0;
    for (const Assembler& assembler : assemblers_) samples += assembler.samples_done();
    return samples;
  }

  absl::StatusOr<std::vector<FollowedImage>> finish() && {
    std::vector<FollowedImage> images;
    for (Assembler& assembler : assemblers_) {
      absl::StatusOr<Assembly> assembly = std::move(assembler).finish();
      if (!assembly.ok()) return assembly.status();
      images.push_back({.image = std::move(assembly->image),
                        .rows = std::move(assembly->rows),
                        .incomplete_pixels = assembly->incomplete_pixels,
                        .holes = std::move(assembly->holes),
                        .denoised = absl::OkStatus()});
    }
    return images;
  }

 private:
  std::vector<Assembler> assemblers_;
};

/// Hands the result to whoever looks on, and to the pictures where there are some.
absl::Status add_result(const v1::UnitResult& unit, const FollowOptions& how, Pictures* pictures) {
  const std::uint32_t view = wire::view_of(unit.unit());
  absl::StatusOr<wire::TileResult> result = wire::decode_tile_result(unit.payload());
  if (result.ok() && view == 0 && how.show) how.show(*result);
  absl::Status status = result.status();
  if (status.ok() && pictures != nullptr) status = pictures->add(view, *std::move(result));
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
  absl::StatusOr<Pictures> pictures = Pictures::begin(spec, how);
  if (!pictures.ok()) return pictures.status();

  Tale tale{spec, how};
  FollowedJob followed;
  std::uint32_t units = 0;
  std::stop_source enough;
  const std::stop_callback stopped{stop, [&] { enough.request_stop(); }};
  JobCalls::WatchHandlers handlers;
  handlers.result = [&](const v1::UnitResult& unit) {
    ++units;
    return add_result(unit, how, &*pictures);
  };
  handlers.status = [&](const v1::JobStatus& status) {
    followed.status = status;
    tale.tell(status, pictures->samples_done());
    if (partial.units > 0 && units >= partial.units) enough.request_stop();
  };
  handlers.restart = [&]() -> absl::Status {
    units = 0;
    if (how.show_anew) how.show_anew();
    auto again = Pictures::begin(spec, how);
    if (!again.ok()) return again.status();
    pictures = std::move(again);
    return absl::OkStatus();
  };
  absl::StatusOr<v1::JobStatus> status = farm.watch(job_id, handlers, enough.get_token());
  tale.tell(status.ok() ? *status : followed.status, pictures->samples_done());
  tale.end();
  if (status.ok()) {
    followed.status = *std::move(status);
  } else if (!partial.wanted) {
    return status.status();
  } else if (stop.stop_requested() || !enough.stop_requested()) {
    followed.broken_off = status.status();
  }

  const bool over = followed.status.state() == v1::DONE || followed.status.state() == v1::INCOMPLETE;
  if (over || (partial.wanted && pictures->samples_done() > 0)) {
    absl::StatusOr<std::vector<FollowedImage>> images = std::move(*pictures).finish();
    if (!images.ok()) return images.status();
    followed.images = *std::move(images);
  }
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
    if (followed.images.empty())
      return report(static_cast<ExitCode>(code), "nothing was rendered, so no image is written");
    return report(static_cast<ExitCode>(code),
                  absl::StrCat("the image is a partial one: ", status.units_done(), " of ",
                               status.units_total(), " units"));
  }
  return has_ended(status.state()) ? report_end(status) : kDone;
}

/// Has the picture of a view tell of its making.
void describe_view(const FollowedJob& followed, const v1::JobSpec& spec, std::uint32_t view,
                   FollowedImage& of_view) {
  Image& image = of_view.image;
  RenderInfo info = render_info(spec, followed.status);
  info.seed = wire::seed_of(spec, view);
  set_render_info(info, image);
  add_film_facts(spec, image);
  add_file_facts(spec.farm().name(), std::time(nullptr), image);
  mark_biased(image);
  if (followed.images.size() > 1) image.metadata["tessera.view"] = static_cast<std::int32_t>(view);
  if (followed.status.state() != v1::DONE && of_view.incomplete_pixels > 0) {
    image.metadata["tessera.partial"] =
        absl::StrCat(followed.status.units_done(), " of ", followed.status.units_total(), " units");
  }
  const auto& warnings = followed.status.stats().warnings();
  if (!warnings.empty()) {
    const std::set<std::string> sorted(warnings.begin(), warnings.end());
    image.metadata["tessera.warnings"] = absl::StrJoin(sorted, "\n");
  }
  if (!of_view.holes.empty()) image.metadata["tessera.holes"] = list_of(of_view.holes);
}

/// Writes all pictures to one file. Views that have no name get one, by their numbers.
absl::Status write_views_together(FollowedJob& followed, const std::string& output, const ExrFormat& exr) {
  std::vector<ExrView> views;
  for (FollowedImage& of_view : followed.images) {
    of_view.image.metadata.try_emplace("view", absl::StrCat("v", views.size()));
    views.push_back({&of_view.image, of_view.rows.get()});
  }
  return write_exr_views(views, output, exr);
}

/// The exit code of what went wrong with a view's picture; where the job did not end well, that was told
/// already.
int end_of_view(FollowedImage& of_view, const absl::Status& written, const std::string& output,
                bool is_done) {
  if (!written.ok()) return report(kIncomplete, std::string{written.message()});
  of_view.written = true;
  if (!is_done) return kDone;
  if (of_view.incomplete_pixels > 0)
    return report(kIncomplete, absl::StrCat(of_view.incomplete_pixels, " pixels lack samples"));
  if (!of_view.denoised.ok()) {
    return report(kNotDenoised,
                  absl::StrCat(output, " is as it was rendered, not denoised: ", of_view.denoised.message()));
  }
  return kDone;
}

}  // namespace

std::uint64_t frame_memory(const ExrFormat& exr, std::uint64_t denoising) {
  const std::uint64_t available = base::available_memory();
  if (denoising > 0 && denoising <= available) return UINT64_MAX;
  constexpr std::uint64_t kMost = std::uint64_t{1} << 30;
  return exr.frame_memory ? *exr.frame_memory : std::min(kMost, available / 4);
}

std::string output_of_view(const std::string& output, std::uint32_t view, std::uint32_t views) {
  if (view == 0) return output;
  const std::filesystem::path path = output;
  const std::string last = std::to_string(views - 1), number = std::to_string(view);
  const std::string name =
      absl::StrCat(path.stem().string(), ".v", std::string(last.size() - number.size(), '0'), number,
                   path.extension().string());
  return (path.parent_path() / name).string();
}

int deliver(FollowedJob& followed, const v1::JobSpec& spec, const std::string& output, const ExrFormat& exr,
            bool quiet) {
  if (!quiet) {
    for (const std::string& warning : followed.status.stats().warnings())
      std::cerr << "warning: " << base::printable(warning) << '\n';
  }
  const int ended = end_of(followed);
  int code = ended;
  const auto views = static_cast<std::uint32_t>(followed.images.size());
  const bool together = exr.multiview && views > 1 && is_exr(output);
  for (std::uint32_t view = 0; view < views; ++view)
    describe_view(followed, spec, view, followed.images[view]);
  const absl::Status all = together ? write_views_together(followed, output, exr) : absl::OkStatus();
  // The file that has the name itself comes last: where it is there, all are.
  for (std::uint32_t view = views; view-- > 0;) {
    FollowedImage& of_view = followed.images[view];
    const std::string file = together ? output : output_of_view(output, view, views);
    absl::Status written = all;
    if (!together)
      written = of_view.rows ? write_image(of_view.image, *of_view.rows, file, exr)
                             : write_image(of_view.image, file, exr);
    const int end = end_of_view(of_view, written, file, /*is_done=*/ended == kDone);
    if (end == kIncomplete || (code == kDone && end != kDone)) code = end;
    if (!all.ok()) break;  // told once
  }
  return code;
}

}  // namespace tessera::client
