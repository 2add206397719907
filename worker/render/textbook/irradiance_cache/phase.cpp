#include "render/textbook/irradiance_cache/phase.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "render/film/film_part.h"
#include "render/integrator/algorithm_list.h"
#include "render/sensor/sensor.h"
#include "render/textbook/irradiance_cache/gather.h"
#include "render/textbook/irradiance_cache/irradiance_cache.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// A record is made where none reaches with this part of the error that the picture allows: so most points of
/// the picture are reached by several, and their weights fall to zero without a seam.
constexpr float kOverlap = 0.7f;

/// All that a blob holds.
struct Records {
  std::vector<IrradianceRecord> even;
  GlossyRecords glossy;
};

std::string blob_of(const Records& records) {
  return blob_of(std::span(records.even)) + blob_of(records.glossy);
}

/// Appends the records of a blob. False where it is none, or has other bands.
bool append_records(std::string_view blob, Records& records) {
  return take_records(blob, records.even) && append_records(blob, records.glossy);
}

bool append_records(std::span<const std::string_view> blobs, Records& records) {
  return std::all_of(blobs.begin(), blobs.end(),
                     [&](std::string_view blob) { return append_records(blob, records); });
}

/// Whether one of the sites from `first` on reaches the place.
bool is_reached(const RecordPlace& place, const auto& sites, std::size_t first, float error) {
  const Vec3 p{Float(place.p[0]), Float(place.p[1]), Float(place.p[2])},
      n{Float(place.n[0]), Float(place.n[1]), Float(place.n[2])};
  return std::any_of(sites.begin() + static_cast<std::ptrdiff_t>(first), sites.end(),
                     [&](const RecordSite& site) { return any(split_sphere_error(site, p, n) < error); });
}

/// Pixels of a part, each with its first sample.
class PixelsOfPart final : public SampleSource {
 public:
  /// Every `step`th of every `step`th row.
  PixelsOfPart(const FilmRect& part, std::uint32_t step)
      : step_(step), x0_(part.x0), x1_(part.x1), y1_(part.y1), x_(part.x0), y_(part.y0) {}

  std::size_t next(std::span<SampleName> names) override {
    std::size_t n = 0;
    for (; y_ < y1_ && x0_ < x1_; y_ += step_, x_ = x0_) {
      for (; x_ < x1_; x_ += step_) {
        if (n == names.size()) return n;
        names[n++] = {x_, y_, 0, 0};
      }
    }
    return n;
  }

 private:
  const std::uint32_t step_, x0_, x1_, y1_;
  std::uint32_t x_, y_;
};

/// Follows paths from the eye as the picture does, and makes records where they would have none.
class Recorder final : private Wavefront, private PathObserver {
 public:
  Recorder(const IntegratorContext& context, const IrradianceCache* given)
      : Wavefront(context), given_(given), gather_(context, given) {
    records_.glossy.bands = scene_.irradiance_cache.glossy_bands;
    add(*this);
  }

  bool look_at(SampleSource& pixels, std::stop_token stop) {
    while (batch_.start(pixels, paths_) && !stop.stop_requested()) {
      std::fill_n(travelled_, kPadded, 0.0f);
      trace(0, batch_.size());
      const std::size_t even = records_.even.size(), glossy = records_.glossy.sites.size();
      for (const RecordPlace& place : bare_) {
        if (stop.stop_requested()) return false;
        if (place.glossy ? !is_reached(place, records_.glossy.sites, glossy, error_)
                         : !is_reached(place, records_.even, even, error_))
          make_record(place);
      }
      bare_.clear();
    }
    return !stop.stop_requested();
  }
  const Records& records() const { return records_; }

 private:
  /// Where there is room, and where the light that was found makes one that lookups can trust.
  void make_record(const RecordPlace& place) {
    GlossyRecords& glossy = records_.glossy;
    if (place.glossy) {
      if ((glossy.sites.size() + 1) * glossy.record_bytes() > wire::kMostRecordBytes) return;
      gather_.make_record(place, glossy);
      take_back_unsound(glossy);
      return;
    }
    if ((records_.even.size() + 1) * sizeof(IrradianceRecord) > wire::kMostRecordBytes) return;
    const IrradianceRecord record = gather_.make_record(place);
    if (is_sound_record(record)) records_.even.push_back(record);
  }

  void met(Encounter& e) override {
    const WidePath& path = e.path;
    const Vertex& v = e.vertex;
    const Float way = gather(travelled_, path.slot, e.on_surface) + e.hit.t;
    scatter(way, travelled_, path.slot, e.on_surface);
    const Cacheable wanted = cacheable(scene_, v, e.on_surface, e.depth);
    e.settled |= wanted.any();
    if (none(wanted.any())) return;
    const Vec3 n = cached_normal(v);
    Mask bare = wanted.any();
    if (given_ != nullptr) bare = and_not(bare, given_->covers(v.surface.p, n, error_, wanted.glossy, bare));
    bare = left_of(records_.even, v.surface.p, n, bare & wanted.even) |
           left_of(records_.glossy.sites, v.surface.p, n, bare & wanted.glossy);
    const Float pixel = pixel_width(scene_.sensor, way);
    const UInt key = hash(batch_.key(path.slot, bare), UInt(static_cast<std::uint32_t>(e.depth)));
    const Vec3 &p = v.surface.p, &ng = v.surface.ng;
    for (std::uint32_t bits = bare.bits(); bits != 0; bits &= bits - 1) {
      const int lane = __builtin_ctz(bits);
      bare_.push_back({.p = {p.x.lane(lane), p.y.lane(lane), p.z.lane(lane)},
                       .ng = {ng.x.lane(lane), ng.y.lane(lane), ng.z.lane(lane)},
                       .error = v.surface.error.lane(lane),
                       .n = {n.x.lane(lane), n.y.lane(lane), n.z.lane(lane)},
                       .pixel = pixel.lane(lane),
                       .random_key = key.lane(lane),
                       .glossy = (wanted.glossy.bits() >> lane & 1) != 0});
    }
  }

  /// The lanes that none of the sites reaches.
  Mask left_of(const auto& sites, Vec3 p, Vec3 n, Mask lanes) const {
    for (const RecordSite& site : sites) {
      if (none(lanes)) break;
      lanes = and_not(lanes, split_sphere_error(site, p, n) < error_);
    }
    return lanes;
  }

  const float error_ = kOverlap * scene_.irradiance_cache.error;
  const IrradianceCache* const given_;  // made before; may be null
  Gather gather_;
  Records records_;
  std::vector<RecordPlace> bare_;       // places of the batch that nothing reached when it began
  alignas(64) Lanes<float> travelled_;  // length of each sample's path
};

}  // namespace

bool make_records(const IntegratorContext& context, const PartRequest& part, std::stop_token stop,
                  std::string& blob) {
  constexpr std::uint32_t kFirstStep = 8;  // pixels
  const std::uint64_t samples = context.stats.samples;
  const auto recorder =
      std::make_unique<Recorder>(context, static_cast<const IrradianceCache*>(part.prepared));
  const SensorRecord& film = context.scene.sensor;
  PixelsOfPart pixels(film_part(film.width, film.height, part), part.phase == 0 ? kFirstStep : 1);
  const bool finished = recorder->look_at(pixels, std::move(stop));
  context.stats.samples = samples;  // the pixels' samples are none of the picture's
  blob = blob_of(recorder->records());
  return finished;
}

bool merge_records(std::span<const std::string_view> blobs, std::string& merged) {
  Records all;
  if (!blobs.empty()) {
    // All have the bands of the first.
    std::string_view rest = blobs.front();
    std::vector<IrradianceRecord> first;
    if (!take_records(rest, first)) return false;
    all.glossy.bands = wire::bands_of(rest);
  }
  if (all.glossy.bands < 0 || !append_records(blobs, all)) return false;
  merged = blob_of(all);
  return true;
}

std::unique_ptr<const Prepared> prepare_records(const SceneTables& scene,
                                                std::span<const std::string_view> blobs) {
  Records all;
  all.glossy.bands = scene.irradiance_cache.glossy_bands;
  if (!append_records(blobs, all)) return nullptr;
  return std::make_unique<IrradianceCache>(std::move(all.even), scene.irradiance_cache.error,
                                           std::move(all.glossy));
}

// Both phases do the same; the second reads what the first has made.
constexpr AlgorithmPhase kPhases[] = {{&make_records, &merge_records}, {&make_records, &merge_records}};
const ListedAlgorithm irradiance_cache{
    {"irradiance-cache", &make<IrradianceCached>, kPhases, &prepare_records}};

}  // namespace tessera::render::TESSERA_ISA
