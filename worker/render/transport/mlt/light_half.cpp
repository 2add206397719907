// Subpaths from lights: up to the vertex that is joined to the eye's subpath, or to the camera.
#include "render/integrator/stage_timer.h"
#include "render/sensor/sensor.h"
#include "render/transport/mlt/path_maker.h"
#include "render/transport/vertex/dimensions.h"
#include "render/transport/vertex/light_step.h"
#include "render/transport/vertex/sensor_joins.h"

namespace tessera::render::TESSERA_ISA {

namespace {

int first_light_pair(int event) {
  return dimension::kFirstLightEvent + event * dimension::kPairsPerLightEvent;
}

}  // namespace

void PathMaker::trace_light(PathBatch& batch) {
  kept_.clear();
  if (!emits_paths(scene_)) return;
  start_at_lights(batch);
  for (int event = 0; frontier_.size() > 0; ++event) {
    intersect(false);
    if (scene_.volumetric) {
      const StageTimer timer(stats_.times, Stage::kTransit);
      transit_.move(frontier_.paths, frontier_.hits, frontier_.size(), event,
                    numbers_on_the_way(batch, event, true), nullptr);
    }
    shade_light(batch, event);
  }
}

void PathMaker::start_at_lights(const PathBatch& batch) {
  const StageTimer timer(stats_.times, Stage::kCamera);
  frontier_.clear();
  starts_.clear();
  for (int k = 0; k * kWidth < batch.count; ++k) {
    const Mask wanted = Mask::first(batch.count - k * kWidth) & (batch.ways_from_light(k) >= 2);
    if (none(wanted)) continue;
    const Int slot = Int::iota(k * kWidth);
    LightStart start = start_at_light(scene_, PrimaryNumbers(batch, k), 1.0f, slot, wanted);
    starts_.add(k, start);
    frontier_.replace(scene_, k, start.path, start.alive);
  }
  frontier_.end_step();
  starts_.enter_media(frontier_);
}

void PathMaker::shade_light(PathBatch& batch, int event) {
  const StageTimer timer(stats_.times, Stage::kShading);
  for (int k = 0; k < kPackets; ++k) {
    const Mask active = frontier_.lanes(k);
    if (none(active)) continue;
    const Int entry = frontier_.entries(k);
    const Hit found = frontier_.hit(entry, active);
    const Mask hit = active & (found.shape >= 0),
               events = hit | (active & (found.shape == kScatteredByMedium));
    if (none(events)) {
      frontier_.drop(k);
      continue;
    }
    WidePath path = frontier_.path(scene_, entry, active);
    const PrimaryNumbers numbers(batch, k);
    const Mask ends = events & (batch.ways_from_light(k) == event + 2),
               at_sensor = ends & (batch.ways_from_eye(k) == 1), kept = and_not(ends, at_sensor);
    LightVertex& here = any(kept) ? kept_.add(event, k) : unkept_vertex_;
    meet_surface(scene_, path, found, numbers, first_light_pair(event), hit, here.vertex);
    here.beta = path.beta;
    here.wavelengths = path.wavelengths;
    here.dispersed = path.dispersed;
    here.joinable = joinable(here.vertex, ends);
    here.weights = arrive_from_light(event, k, path, here.vertex, events);
    if (const Mask wanted = at_sensor & here.joinable; any(wanted))
      join_to_sensor(batch, here, event, k, wanted);
    go_on_from_light(here, path, numbers, event, k, and_not(events, ends));
  }
  frontier_.end_step();
}

PartialWeights PathMaker::arrive_from_light(int event, int packet, const WidePath& path, const Vertex& v,
                                            Mask hit) const {
  if (event > 0) {
    PartialWeights weights = weights_.load(packet);
    const Vec3 before = scene_.volumetric ? path.reference : path.origin;
    weights.arrive(length_squared(v.surface.p - before) * UnitArea(scene_.lights).inverse,
                   cosine_at(v, v.wo));
    return weights;
  }
  return starts_.first_weights(packet, v, hit);
}

void PathMaker::join_to_sensor(PathBatch& batch, const LightVertex& here, int event, int packet,
                               Mask wanted) {
  const Vec2 u_lens = PrimaryNumbers(batch, packet).get_2d(first_light_pair(event) + dimension::kJoinLens);
  const FilmRect film{0, 0, static_cast<std::uint32_t>(scene_.sensor.width),
                      static_cast<std::uint32_t>(scene_.sensor.height)};
  SensorJoin join =
      sensor_join(scene_, here.vertex, here.beta, here.dispersed, here.wavelengths, u_lens, film, wanted);
  if (none(join.seen)) return;
  const Float density =
      join.eye.density * UnitArea(scene_.lights).size * cosine_at(here.vertex, join.w) * (1.0f / film_area_);
  const Float weight = weight_of_way(here.weights.ways(density, join.back.pdf, Float(0.0f)), Float(0.0f));
  join.value *= weight * scale_of(batch, packet, false);
  Mask shines = join.seen;
  WideConnection ray = ray_of(scene_, here.vertex, join, shines);
  if (scene_.volumetric) ray.wavelengths = here.wavelengths;
  const int first = packet * kWidth;
  select(shines, join.eye.raster.x, Float::load(batch.film_x + first)).store(batch.film_x + first);
  select(shines, join.eye.raster.y, Float::load(batch.film_y + first)).store(batch.film_y + first);
  queue(batch, ray, Int::iota(first), join_salt(event), shines);
}

void PathMaker::go_on_from_light(const LightVertex& here, const WidePath& path, const PrimaryNumbers& numbers,
                                 int event, int packet, Mask hit) {
  if (none(hit)) {
    frontier_.drop(packet);
    return;
  }
  const int pair = first_light_pair(event);
  LightStep step = step_from_light(scene_, here.vertex, path, numbers.get_2d(pair + dimension::kLobe).x,
                                   numbers.get_2d(pair + dimension::kLightBsdfDirection), hit);
  weights_.store(here.weights.scattered(cosine_at(here.vertex, step.next.direction), step.pdf, step.back_pdf,
                                        Float(0.0f), step.specular),
                 packet);
  frontier_.replace(scene_, packet, step.next, step.alive);
}

}  // namespace tessera::render::TESSERA_ISA
