#include "scheduler/work_plan.h"

#include <algorithm>
#include <bit>
#include <functional>
#include <string>

#include "absl/strings/str_cat.h"
#include "wire/algorithm.h"
#include "wire/aov_channels.h"
#include "wire/digest.h"
#include "wire/film_size.h"
#include "wire/job_check.h"
#include "wire/limits.h"
#include "wire/scene_views.h"

namespace tessera::server {
namespace {

absl::Status unsound(const std::string& what) {
  return absl::InvalidArgumentError(absl::StrCat("job: ", what));
}

std::uint32_t divide_up(std::uint64_t a, std::uint64_t b) {
  return static_cast<std::uint32_t>((a + b - 1) / b);
}

absl::Status check_film(const v1::JobSpec& spec) {
  const v1::JobSpec::View& view = spec.view();
  if (!wire::is_film_size(view.width(), view.height())) {
    return unsound(absl::StrCat("width and height are ", view.width(), " and ", view.height(), "; ",
                                wire::kFilmSizes, ", were expected"));
  }
  const v1::PixelRect& crop = spec.cut().crop();
  if (crop.x0() >= crop.x1() || crop.y0() >= crop.y1() || crop.x1() > view.width() ||
      crop.y1() > view.height()) {
    return unsound(absl::StrCat("crop [", crop.x0(), ",", crop.x1(), ") x [", crop.y0(), ",", crop.y1(),
                                ") is empty or not within the film"));
  }
  // Jobs with the same AOVs have the same view.
  if (!std::is_sorted(view.aovs().begin(), view.aovs().end(), std::less_equal<int>())) {
    return unsound("its AOVs are not in ascending order, each once");
  }
  // A pass comes back whole, in one message: a count and the channels of every pixel.
  const std::uint64_t pixels = std::uint64_t{crop.x1() - crop.x0()} * (crop.y1() - crop.y0());
  const std::uint64_t most = wire::kMaxMessageBytes / (4 * (wire::channels_of(view).size() + 1));
  if (wire::works_in_passes(spec) && pixels > most) {
    return unsound(absl::StrCat("integrator ", spec.content().algorithms().integrator(), " cannot render ",
                                pixels, " pixels at once, but ", most, "; crops of the film would fit"));
  }
  return absl::OkStatus();
}

absl::Status check_cut(const v1::JobSpec& spec) {
  const std::uint32_t tile_size = spec.cut().tile_size(), spp = spec.samples().spp();
  if (tile_size == 0 || tile_size > wire::kMaxTileSize) {
    return unsound(absl::StrCat("tile_size is ", tile_size, "; 1 to ", wire::kMaxTileSize, " was expected"));
  }
  // A tile comes back whole, in one message.
  const std::uint64_t bytes_per_pixel = 4 * (wire::channels_of(spec.view()).size() + 1);
  if (std::uint64_t{tile_size} * tile_size * bytes_per_pixel > wire::kMaxMessageBytes) {
    return unsound(absl::StrCat("tiles of ", tile_size, "x", tile_size, " pixels with ", bytes_per_pixel,
                                " bytes each are too large; smaller ones would fit"));
  }
  if (!std::has_single_bit(spec.cut().samples_per_unit())) {
    return unsound(
        absl::StrCat("samples_per_unit is ", spec.cut().samples_per_unit(), "; a power of two was expected"));
  }
  if (spp == 0 || spp > wire::kMaxSamplesPerPixel) {
    return unsound(
        absl::StrCat("samples.spp is ", spp, "; 1 to ", wire::kMaxSamplesPerPixel, " was expected"));
  }
  return absl::OkStatus();
}

absl::Status check_blobs(const v1::JobSpec& spec) {
  const std::string& scene = spec.content().scene();
  if (!wire::is_digest(scene)) return unsound("scene has no SHA-256 digest");
  if (spec.farm().blobs_size() > wire::kMaxBlobsPerJob) {
    return unsound(absl::StrCat("it has ", spec.farm().blobs_size(), " blobs; at most ",
                                wire::kMaxBlobsPerJob, " were expected"));
  }
  bool has_scene = false;
  for (const v1::BlobRef& blob : spec.farm().blobs()) {
    has_scene = has_scene || blob.digest() == scene;
    if (!wire::is_digest(blob.digest()))
      return unsound(
          absl::StrCat("blob \"", blob.path().substr(0, wire::kMaxTextBytes), "\" has no SHA-256 digest"));
    if (blob.path().size() > wire::kMaxTextBytes) return unsound("the path of a blob is too long");
  }
  return has_scene ? absl::OkStatus() : unsound("its scene is not among its blobs");
}

constexpr int kMostCandidates = 64;  // among which an integrator was chosen

absl::Status check_names(const v1::JobSpec& spec) {
  const v1::JobSpec::Farm& farm = spec.farm();
  std::size_t tags = 0;
  for (const std::string& tag : farm.required_tags()) tags += tag.size() + 1;
  std::size_t ids = 0;
  for (const std::string& id : farm.after()) ids = std::max(ids, id.size());
  if (farm.after_size() > wire::kMaxAfter)
    return unsound(absl::StrCat("it comes after ", farm.after_size(), " jobs; at most ", wire::kMaxAfter,
                                " are possible"));
  const std::size_t longest =
      std::max({farm.name().size(), farm.isa().size(), farm.user().size(), tags, ids, farm.comment().size(),
                farm.webhook().size(), farm.group().size(), spec.content().algorithms().integrator().size()});
  if (longest > wire::kMaxTextBytes) return unsound("a name is too long");
  const v1::AutoChoice& choice = farm.auto_choice();
  std::size_t told = choice.reason().size();
  for (const v1::AutoChoice::Candidate& candidate : choice.candidates())
    told = std::max({told, candidate.integrator().size(), candidate.left_out().size()});
  if (told > wire::kMaxTextBytes || choice.candidates_size() > kMostCandidates)
    return unsound("how its integrator was chosen is told at too great a length");
  return absl::OkStatus();
}

absl::Status check(const v1::JobSpec& spec) {
  if (spec.content().scene().empty()) return unsound("it names no scene; is its client of another version?");
  if (absl::Status status = check_names(spec); !status.ok()) return status;
  if (absl::Status status = wire::check_settings(spec); !status.ok())
    return unsound(std::string(status.message()));
  for (const auto part : {&check_blobs, &check_film, &check_cut}) {
    if (absl::Status status = part(spec); !status.ok()) return status;
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<WorkPlan> WorkPlan::make(const v1::JobSpec& spec) {
  if (absl::Status status = check(spec); !status.ok()) return status;
  absl::StatusOr<PhasePlan> phases = PhasePlan::make(spec);
  if (!phases.ok()) return phases.status();
  WorkPlan plan;
  plan.phases_ = *std::move(phases);
  plan.crop_ = spec.cut().crop();
  plan.views_ = wire::views_of(spec);
  plan.passes_ = wire::works_in_passes(spec);
  plan.tile_size_ =
      plan.passes_ ? std::max(spec.view().width(), spec.view().height()) : spec.cut().tile_size();
  plan.samples_ = spec.samples().spp();
  plan.samples_per_unit_ = spec.cut().samples_per_unit();
  plan.range_count_ = divide_up(plan.samples_, plan.samples_per_unit_);
  plan.first_column_ = plan.crop_.x0() / plan.tile_size_;
  plan.first_row_ = plan.crop_.y0() / plan.tile_size_;
  const std::uint32_t columns = divide_up(plan.crop_.x1(), plan.tile_size_) - plan.first_column_;
  const std::uint32_t rows = divide_up(plan.crop_.y1(), plan.tile_size_) - plan.first_row_;

  // Each factor by itself first: their product may not fit into 64 bits.
  const std::uint64_t tiles = std::uint64_t{columns} * rows;
  if (tiles > wire::kMaxUnitsPerJob || plan.views_ > wire::kMaxUnitsPerJob / tiles ||
      plan.phases_.unit_count() + tiles * plan.views_ * plan.range_count_ > wire::kMaxUnitsPerJob) {
    return unsound(
        absl::StrCat(tiles, " tiles", plan.views_ == 1 ? "" : absl::StrCat(" of ", plan.views_, " views"),
                     " times ", plan.range_count_, " sample ranges are more than ", wire::kMaxUnitsPerJob,
                     " units; larger tiles or more samples a unit would help"));
  }
  plan.tile_order_ = TileOrder{columns, rows};
  return plan;
}

UnitRun WorkPlan::longest_run(std::uint32_t first) const {
  if (!is_of_picture(first)) return {.first = first};
  const std::uint32_t range = (first - phases_.unit_count()) / tile_count();
  const std::uint32_t whole_ranges = samples_ / samples_per_unit_;
  // The last range may have fewer samples: a run with it would not be the node that it is where there are
  // more.
  std::uint32_t count = range >= whole_ranges ? 1 : std::bit_floor(whole_ranges - range);
  if (range > 0) count = std::min(count, range & (~range + 1));  // the largest power of two that divides it
  return {.first = first, .count = count, .step = tile_count()};
}

std::optional<UnitRun> WorkPlan::run(std::uint32_t first, std::uint32_t count) const {
  if (first >= unit_count() || !std::has_single_bit(count)) return std::nullopt;
  UnitRun run = longest_run(first);
  if (count > run.count) return std::nullopt;
  run.count = count;
  return run;
}

v1::WorkUnit WorkPlan::unit(const UnitRun& run) const {
  if (!is_of_picture(run.first)) return phases_.unit(run.first);
  const std::uint32_t range = (run.first - phases_.unit_count()) / tile_count();
  const std::uint32_t view = tile_of(run.first) / tile_order_.count();
  const TileOrder::Tile tile = tile_order_.tile(tile_of(run.first) % tile_order_.count());
  const std::uint32_t x = (first_column_ + tile.column) * tile_size_;
  const std::uint32_t y = (first_row_ + tile.row) * tile_size_;

  v1::WorkUnit unit;
  unit.set_index(run.first);
  v1::SampleRange& samples =
      passes_ ? *unit.mutable_pass()->mutable_passes() : *unit.mutable_tile()->mutable_samples();
  samples.set_begin(range * samples_per_unit_);
  samples.set_end(static_cast<std::uint32_t>(
      std::min<std::uint64_t>((std::uint64_t{range} + run.count) * samples_per_unit_, samples_)));
  if (passes_) {
    unit.mutable_pass()->set_view(view);
    return unit;
  }
  unit.mutable_tile()->set_view(view);
  v1::PixelRect& pixels = *unit.mutable_tile()->mutable_pixels();
  pixels.set_x0(std::max(x, crop_.x0()));
  pixels.set_y0(std::max(y, crop_.y0()));
  pixels.set_x1(std::min(x + tile_size_, crop_.x1()));
  pixels.set_y1(std::min(y + tile_size_, crop_.y1()));
  return unit;
}

v1::TileUnit extent_of(const v1::WorkUnit& unit, const v1::JobSpec& spec) {
  if (unit.has_tile()) return unit.tile();
  v1::TileUnit extent;
  *extent.mutable_pixels() = spec.cut().crop();
  *extent.mutable_samples() = unit.pass().passes();
  extent.set_view(unit.pass().view());
  return extent;
}

}  // namespace tessera::server
