#include "render/transport/mlt/path_maker.h"

#include <algorithm>

#include "render/integrator/stage_timer.h"
#include "render/sensor/sensor.h"

namespace tessera::render::TESSERA_ISA {

PathMaker::PathMaker(const IntegratorContext& context)
    : context_(context),
      scene_(context.scene),
      rays_(context.rays),
      stats_(context.stats),
      connects_(connects_to_points(context.scene.sensor)),
      starts_(context),
      transit_(context) {
  // Filters are about the pixels' centres. What a film without an edge sees beyond it, it sees within, too.
  const RasterEdges edges = edges_of(scene_.sensor);
  const bool open = edges == RasterEdges::kOpen;
  left_ = open ? 0.5f - scene_.filter.x.radius : 0.0f;
  top_ = open || edges == RasterEdges::kRound ? 0.5f - scene_.filter.y.radius : 0.0f;
  width_ = static_cast<float>(scene_.sensor.width) - 2 * left_;
  height_ = static_cast<float>(scene_.sensor.height) - 2 * top_;
  film_area_ = width_ * height_;
  if (scene_.volumetric) emission_.emplace(context);
}

bool PathMaker::asks_for(int place_of_event) const {
  switch (place_of_event) {
    case kFlightPlace:
    case kLightFlightPlace:
      return scene_.volumetric;
    case kOpacityPlace:
      return scene_.any_opacity && !scene_.volumetric;
    case dimension::kRoulette:
    case kFirstLightPlace + dimension::kLightRoulette:
      return scene_.any_mix;  // nothing ends by chance
    default:
      return true;
  }
}

void PathMaker::make(PathBatch& batch) {
  for (int i = 0; i < batch.count; i += kWidth) store_lanes(Spectrum(0.0f), batch.light, i);
  joins_.size = 0;
  trace_light(batch);
  trace_eye(batch);
  trace_joins(batch);
}

void PathMaker::intersect(bool from_sensor) {
  const StageTimer timer(stats_.times, Stage::kIntersection);
  stats_.bounce_rays += static_cast<std::uint64_t>(frontier_.size());
  find_hits(scene_, rays_, frontier_.paths, frontier_.size(), from_sensor ? 0 : 1, PathOrder::kAny,
            frontier_.hits);
}

TransitNumbers PathMaker::numbers_on_the_way(const PathBatch& batch, int event, bool from_light) const {
  TransitNumbers numbers{batch.keys, from_light ? dimension::kLightFlight : dimension::kFlight,
                         from_light ? 0x4c696768u : 0u};
  if (const int place = place_of(numbers.flight + event); place >= 0) {
    const PathBatch::Pair& pair = batch.coordinates_by_place[static_cast<std::size_t>(place)];
    numbers.distance_x = pair.x;
    numbers.distance_y = pair.y;
  }
  return numbers;
}

Float PathMaker::scale_of(const PathBatch& batch, int packet, bool from_eye) const {
  const Float ways = to_float(Int::load(batch.events + packet * kWidth)) + (connects_ ? 2.0f : 1.0f);
  return from_eye ? ways * (film_area_ * scene_.sensor.response.exposure) : ways;
}

void PathMaker::add(PathBatch& batch, Spectrum more, int packet, Mask lanes) {
  Spectrum sum;
  load_lanes(batch.light, packet * kWidth, sum);
  store_lanes(select(lanes, sum + more, sum), batch.light, packet * kWidth);
}

void PathMaker::queue(const PathBatch& batch, WideConnection ray, Int slot, std::uint32_t salt, Mask shines) {
  ray.slot = slot;
  if (scene_.volumetric) ray.key = bit_cast<std::int32_t>(hash(batch.keys.key(slot, shines) ^ salt));
  joins_.size += append(scene_, ray, shines, joins_, joins_.size);
}

void PathMaker::trace_joins(PathBatch& batch) {
  const StageTimer timer(stats_.times, Stage::kShadow);
  if (scene_.volumetric) {
    transit_.march(Passenger::kPath, joins_, join_hits_, 0, [&](const WideConnection& ray, Mask arrived) {
      scatter_lanes(ray.contribution, batch.light, ray.slot, arrived);
    });
    return;
  }
  rays_.occluded(arrays_of(joins_.origin, joins_.direction, scene_.any_motion ? joins_.time : nullptr),
                 joins_.size, joins_.distance);
  stats_.shadow_rays += static_cast<std::uint64_t>(joins_.size);
  for (int i = 0; i < joins_.size; ++i) {
    if (joins_.distance[i] < 0) continue;
    for (int c = 0; c < kSpectrumLanes; ++c) batch.light.c[c][joins_.slot[i]] = joins_.contribution.c[c][i];
  }
  joins_.size = 0;
}

}  // namespace tessera::render::TESSERA_ISA
