#include "service/web/pictures.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "service/farm/farm_views.h"
#include "service/job/job_table.h"
#include "spectra/sensor/bands.h"
#include "store/blobs/blob_store.h"
#include "wire/algorithm.h"
#include "wire/scene_views.h"

namespace tessera::server {
namespace {

PixelArea crop_of(const v1::JobSpec& spec) {
  const v1::PixelRect& crop = spec.cut().crop();
  return {crop.x0(), crop.y0(), crop.x1(), crop.y1()};
}

bool has_pilot(const v1::JobSpec& spec) { return spec.samples().noise() > 0; }

/// Whether the errors of neighbouring pixels may agree.
bool pixels_share(const v1::JobSpec& spec) {
  const wire::AlgorithmTraits* const algorithm =
      wire::find_algorithm(spec.content().algorithms().integrator());
  return spec.view().reconstruction() == v1::RECONSTRUCTION_SCATTER ||
         spec.view().path_sharing() > v1::PATH_SHARING_OFF || algorithm == nullptr ||
         algorithm->work != wire::WorkKind::kTiles;
}

double cpu_seconds_of(const v1::UnitStats& stats) {
  return static_cast<double>(stats.cpu_time().seconds()) + 1e-9 * stats.cpu_time().nanos();
}

}  // namespace

std::vector<ShownPicture::Band> ShownPicture::bands_of(const JobShape& shape) {
  std::vector<Band> bands;
  for (std::size_t c = 0; c < shape.channels.size(); ++c) {
    // A band's deviations have its name with an end of their own.
    if (const auto nm = spectra::centre_of_channel(shape.channels[c].name)) bands.push_back({c, *nm});
  }
  return bands;
}

ShownPicture::ShownPicture(FarmViews& views, std::string job, std::shared_ptr<const JobShape> shape,
                           PictureLayer layer)
    : views_(views),
      job_(std::move(job)),
      shape_(std::move(shape)),
      area_(crop_of(shape_->spec)),
      layer_(std::move(layer)),
      bands_(bands_of(*shape_)),
      picture_(area_, Picture::level_for(area_), layer_) {}

absl::Status ShownPicture::add(const v1::UnitResult& result, double cpu_seconds) {
  if (wire::view_of(result.unit()) != 0) return absl::OkStatus();
  const absl::StatusOr<wire::TileResult> tile = wire::decode_tile_result(result.payload());
  if (!tile.ok()) return tile.status();
  const std::lock_guard lock(mutex_);
  if (keeps_results()) results_.push_back({result.sequence(), {tile->x0, tile->y0, tile->x1, tile->y1}});
  return picture_.add(*tile, cpu_seconds);
}

bool ShownPicture::follow(std::chrono::steady_clock::time_point deadline) {
  const std::lock_guard following(following_);
  while (std::chrono::steady_clock::now() < deadline) {
    const absl::StatusOr<WatchBatch> batch = views_.next_results(job_, after_, /*status_only=*/false);
    if (!batch.ok()) return false;
    if (batch->response.status().revision() != revision_) {
      // Results that are here already turned out to be wrong.
      const std::lock_guard lock(mutex_);
      revision_ = batch->response.status().revision();
      picture_ = Picture(area_, picture_.level(), layer_);
      pilot_ = nullptr;
      results_.clear();
      ++generation_;
      const bool was_begun = std::exchange(after_, 0) > 0;
      if (was_begun) continue;
    }
    if (batch->last == after_) return false;
    find_pilot();
    std::vector<v1::UnitStats> costs;
    if (layer_.kind == PictureLayer::Kind::kCost) {
      const auto read = views_.costs_of(job_, after_, static_cast<std::uint32_t>(batch->last - after_));
      if (read.ok()) costs = *read;
    }
    for (const v1::UnitResult& result : batch->response.results()) {
      const std::size_t at = result.sequence() - after_ - 1;
      // A result that does not fit is the business of who fetches the image: here it leaves a hole.
      static_cast<void>(add(result, at < costs.size() ? cpu_seconds_of(costs[at]) : 0));
    }
    after_ = batch->last;
  }
  return true;
}

/// The pilot is there before the first result of the picture; or not at all, where the coordinator was
/// started since.
void ShownPicture::find_pilot() {
  if (layer_.noise != PictureLayer::Noise::kPilot || pilot_ != nullptr) return;
  const absl::StatusOr<std::string> blob = views_.last_phase_of(job_);
  auto pilot = std::make_shared<wire::PilotBlocks>();
  if (!blob.ok() || !wire::append_pilot_blob(*blob, *pilot)) return;
  const std::lock_guard lock(mutex_);
  pilot_ = std::move(pilot);
  picture_.set_pilot(pilot_);
}

absl::StatusOr<std::string> ShownPicture::part(std::uint32_t level, const PixelArea& pixels) {
  if (level > 16 || pixels.empty() || std::size_t{pixels.width()} * pixels.height() > kMostPartPixels ||
      pixels.x1 > (area_.width() + (1u << level) - 1) >> level ||
      pixels.y1 > (area_.height() + (1u << level) - 1) >> level) {
    return absl::InvalidArgumentError("the picture has no such part, or it is too large");
  }
  std::vector<std::uint64_t> sequences;
  std::size_t reread = 0;
  PixelArea film;
  std::shared_ptr<const wire::PilotBlocks> pilot;
  {
    const std::lock_guard lock(mutex_);
    if (level >= picture_.level()) return picture_.pixels(level, pixels);
    film = intersection({area_.x0 + (pixels.x0 << level), area_.y0 + (pixels.y0 << level),
                         area_.x0 + (pixels.x1 << level), area_.y0 + (pixels.y1 << level)},
                        area_);
    for (const Result& result : results_) {
      if (intersection(result.area, film).empty()) continue;
      sequences.push_back(result.sequence);
      reread += std::size_t{result.area.width()} * result.area.height();
    }
    pilot = pilot_;
  }
  if (sequences.size() > kMostReread || reread > kMostRereadPixels)
    return absl::ResourceExhaustedError("this part is made of too many results; look at a smaller one");
  Picture fine(film, level, layer_);
  fine.set_pilot(std::move(pilot));
  for (const std::uint64_t sequence : sequences) {
    const absl::StatusOr<wire::TileResult> tile = read(sequence);
    if (!tile.ok()) return tile.status();
    double seconds = 0;
    if (layer_.kind == PictureLayer::Kind::kCost) {
      const auto cost = views_.costs_of(job_, sequence - 1, 1);
      if (cost.ok() && !cost->empty()) seconds = cpu_seconds_of(cost->front());
    }
    if (absl::Status status = fine.add(*tile, seconds); !status.ok()) return status;
  }
  return fine.pixels(level, {0, 0, pixels.width(), pixels.height()});
}

absl::StatusOr<wire::TileResult> ShownPicture::read(std::uint64_t sequence) const {
  const absl::StatusOr<std::string> payload = views_.result_of(job_, sequence);
  if (!payload.ok()) return payload.status();
  return wire::decode_tile_result(*payload);
}

template <class Take>
absl::Status ShownPicture::read_again(const PixelArea& film, Take&& take) {
  std::vector<std::uint64_t> sequences;
  std::size_t reread = 0;
  {
    const std::lock_guard lock(mutex_);
    for (const Result& result : results_) {
      if (intersection(result.area, film).empty()) continue;
      sequences.push_back(result.sequence);
      reread += std::size_t{result.area.width()} * result.area.height() * shape_->channels.size();
    }
  }
  if (sequences.size() > kMostReread || reread > kMostRereadPixels)
    return absl::ResourceExhaustedError("these pixels are made of too many results to read them again");
  for (const std::uint64_t sequence : sequences) {
    const absl::StatusOr<wire::TileResult> tile = read(sequence);
    if (!tile.ok()) return tile.status();
    if (tile->channels.size() == shape_->channels.size()) take(*tile);  // else a hole, as in add()
  }
  return absl::OkStatus();
}

absl::StatusOr<ShownPicture::Spectrum> ShownPicture::spectrum(std::uint32_t x, std::uint32_t y) {
  if (bands_.empty()) return absl::InvalidArgumentError("the job's film has no bands (--film spectral:N)");
  if (x >= area_.width() || y >= area_.height())
    return absl::InvalidArgumentError("the picture has no such pixel");
  const std::uint32_t film_x = area_.x0 + x, film_y = area_.y0 + y;
  Spectrum spectrum;
  std::vector<double> sums(bands_.size());
  const absl::Status done =
      read_again({film_x, film_y, film_x + 1, film_y + 1}, [&](const wire::TileResult& tile) {
        const std::size_t pixels = tile.pixel_count(),
                          at = std::size_t{film_y - tile.y0} * (tile.x1 - tile.x0) + (film_x - tile.x0);
        spectrum.samples += tile.counts[at];
        for (std::size_t b = 0; b < bands_.size(); ++b)
          sums[b] += tile.values[bands_[b].channel * pixels + at];
      });
  if (!done.ok()) return done;
  for (std::size_t b = 0; b < bands_.size(); ++b) {
    spectrum.centres_nm.push_back(bands_[b].centre_nm);
    if (spectrum.samples > 0) spectrum.values.push_back(sums[b] / static_cast<double>(spectrum.samples));
  }
  return spectrum;
}

absl::StatusOr<ShownPicture::MeasuredLight> ShownPicture::measure(std::uint32_t x, std::uint32_t y) {
  const std::optional<MeterChannels> channels = meter_channels(shape_->channels);
  if (!channels || !layer_.is_color()) return absl::InvalidArgumentError("the layer has no colours");
  if (x >= area_.width() || y >= area_.height())
    return absl::InvalidArgumentError("the picture has no such pixel");
  constexpr std::uint32_t kHalf = kMeterBlock / 2;
  const std::uint32_t film_x = area_.x0 + x, film_y = area_.y0 + y;
  const PixelArea around = intersection(
      area_,
      {film_x - std::min(film_x, kHalf), film_y - std::min(film_y, kHalf), film_x + kHalf, film_y + kHalf});
  LightMeter meter(around, *channels);
  const absl::Status done = read_again(around, [&](const wire::TileResult& tile) { meter.add(tile); });
  if (!done.ok()) return done;
  MeasuredLight light;
  light.has_variance = channels->deviations.has_value();
  light.shares = pixels_share(shape_->spec);
  const std::array<double, 3> weights = units().weights;
  light.pixel = meter.read({film_x, film_y, film_x + 1, film_y + 1}, weights, light.shares);
  light.block = meter.read(around, weights, light.shares);
  return light;
}

PixelUnits ShownPicture::units() {
  {
    const std::lock_guard lock(mutex_);
    if (units_) return *units_;
  }
  const absl::StatusOr<std::unique_ptr<BlobReader>> scene = views_.scene_of(job_);
  const auto head = scene.ok() ? read_scene_head(**scene) : absl::StatusOr<v1::Scene>(scene.status());
  const PixelUnits units = head.ok() ? pixel_units_of(*head, shape_->spec) : usual_pixel_units(shape_->spec);
  const std::lock_guard lock(mutex_);
  units_ = units;
  return units;
}

ShownPicture::News ShownPicture::since(std::uint64_t generation, std::uint64_t changes) const {
  const std::lock_guard lock(mutex_);
  News news{.generation = generation_, .changes = picture_.changes(), .areas = {}};
  std::optional<std::vector<PixelArea>> areas;
  if (generation == generation_) areas = picture_.changed_since(changes);
  news.all = !areas;
  if (areas) news.areas = *std::move(areas);
  return news;
}

absl::StatusOr<std::shared_ptr<ShownPicture>> Pictures::open(const std::string& job,
                                                             const std::string& layer) {
  const absl::StatusOr<std::shared_ptr<const JobShape>> shape = views_.shape_of(job);
  if (!shape.ok()) return shape.status();
  const std::vector<PictureLayer> layers = layers_of((*shape)->channels, has_pilot((*shape)->spec));
  const auto found = std::ranges::find(layers, layer, &PictureLayer::name);
  if (found == layers.end()) return absl::NotFoundError(absl::StrCat("job ", job, " has no such layer"));
  const std::lock_guard lock(mutex_);
  if (const auto kept = kept_.find({job, layer}); kept != kept_.end()) {
    kept->second.used = ++uses_;
    return kept->second.picture;
  }
  const PixelArea area = crop_of((*shape)->spec);
  if (!make_room(Picture::bytes_for(area, *found)))
    return absl::ResourceExhaustedError("too many pictures are looked at; close another page");
  Kept& kept = kept_[{job, layer}];
  kept = {.picture = std::make_shared<ShownPicture>(views_, job, *shape, *found), .used = ++uses_};
  return kept.picture;
}

absl::StatusOr<std::shared_ptr<ShownPicture>> Pictures::open_colors(const std::string& job) {
  const absl::StatusOr<std::shared_ptr<const JobShape>> shape = views_.shape_of(job);
  if (!shape.ok()) return shape.status();
  return open(job, layers_of((*shape)->channels, has_pilot((*shape)->spec)).front().name);
}

bool Pictures::make_room(std::size_t bytes) {
  const auto all_bytes = [this] {
    std::size_t sum = 0;
    for (const auto& [key, kept] : kept_)
      sum += Picture::bytes_for(kept.picture->area(), kept.picture->layer());
    return sum;
  };
  while (kept_.size() >= kMost || all_bytes() + bytes > most_bytes_) {
    auto oldest = kept_.end();
    for (auto kept = kept_.begin(); kept != kept_.end(); ++kept) {
      const bool is_seen = kept->second.picture.use_count() > 1;
      if (!is_seen && (oldest == kept_.end() || kept->second.used < oldest->second.used)) oldest = kept;
    }
    if (oldest == kept_.end()) return false;
    kept_.erase(oldest);
  }
  return true;
}

}  // namespace tessera::server
