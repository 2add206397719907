// Subpaths from the eye: up to the vertex where they meet a light, are lit by one, or are joined to the
// light's subpath.
#include "render/integrator/stage_timer.h"
#include "render/sensor/shutter.h"
#include "render/transport/bdpt/ways.h"
#include "render/transport/mlt/path_maker.h"
#include "render/transport/vertex/encounter.h"
#include "render/transport/vertex/sensor_start.h"

namespace tessera::render::TESSERA_ISA {

/// Sixteen subpaths from the eye at the end of their latest segment.
struct PathMaker::Event : NumberedEncounter<PrimaryNumbers> {
  int packet;
  PartialWeights weights;  // before arrive_at() as the path left its last vertex
  [[no_unique_address]] Spectra spectra;

  Event(const SceneTables& scene, const WidePath& paths, const Hit& hits, const PrimaryNumbers& coordinates,
        int event, Mask active, int packet_number, const PartialWeights& sums)
      : NumberedEncounter(scene, paths, hits, coordinates, event, active),
        packet(packet_number),
        weights(sums),
        spectra(spectra_of(scene, paths)) {}

  EyeVertex end() const { return {vertex, weights, path.beta, depth, Float(0.0f), path.dispersed, spectra}; }
};

void PathMaker::trace_eye(PathBatch& batch) {
  start_at_eye(batch);
  for (int depth = 0; frontier_.size() > 0; ++depth) {
    intersect(depth == 0);
    if (scene_.volumetric) {
      const StageTimer timer(stats_.times, Stage::kTransit);
      emission_->start(0, 0, kSubpaths);
      transit_.move(frontier_.paths, frontier_.hits, frontier_.size(), depth,
                    numbers_on_the_way(batch, depth, false), &*emission_);
      add_emission_of_media(batch, depth);
    }
    shade_eye(batch, depth);
  }
}

void PathMaker::start_at_eye(PathBatch& batch) {
  const StageTimer timer(stats_.times, Stage::kCamera);
  frontier_.clear();
  for (int k = 0; k * kWidth < batch.count; ++k) {
    const Mask wanted = Mask::first(batch.count - k * kWidth) & (batch.ways_from_eye(k) >= 2);
    if (none(wanted)) continue;
    const PrimaryNumbers numbers(batch, k);
    const Vec2 u = numbers.get_2d(dimension::kFilm);
    const Vec2 film{fma(u.x, width_, left_), fma(u.y, height_, top_)};
    const int first = k * kWidth;
    select(wanted, film.x, Float::load(batch.film_x + first)).store(batch.film_x + first);
    select(wanted, film.y, Float::load(batch.film_y + first)).store(batch.film_y + first);
    Exposure exposure{Float(0.0f), Float(1.0f)};
    if (scene_.any_motion) {
      exposure.time = time_of_light(scene_.sensor, numbers.get_2d(dimension::kTime).x);
      exposure.weight = exposure_at(scene_.sensor, film, exposure.time);
    }
    const SensorSample start{film, numbers.get_2d(dimension::kLens), exposure.time};
    WidePath path = start_at_sensor(scene_, start, wavelengths_of(numbers), Int::iota(first));
    path.beta *= exposure.weight;
    frontier_.replace(scene_, k, path, wanted);
  }
  frontier_.end_step();
}

/// Light of media on the last segment of paths that no light is sampled for.
void PathMaker::add_emission_of_media(PathBatch& batch, int depth) {
  for (int k = 0; k < kPackets; ++k) {
    const Mask ends =
        frontier_.lanes(k) & (batch.ways_from_eye(k) == depth + 2) & (batch.ways_from_light(k) == 0);
    if (any(ends)) add(batch, emission_->radiance(k * kWidth) * scale_of(batch, k, true), k, ends);
  }
}

void PathMaker::shade_eye(PathBatch& batch, int depth) {
  const StageTimer timer(stats_.times, Stage::kShading);
  for (int k = 0; k < kPackets; ++k) {
    const Mask active = frontier_.lanes(k);
    if (none(active)) continue;
    const Int entry = frontier_.entries(k);
    const WidePath path = frontier_.path(scene_, entry, active);
    Event e(scene_, path, frontier_.hit(entry, active), PrimaryNumbers(batch, k), depth, active, k,
            weights_.load(k));
    const Vertex& v = e.vertex;
    const Int from_light = batch.ways_from_light(k);
    const Mask ends = active & (batch.ways_from_eye(k) == depth + 2), at_light = ends & (from_light == 0);
    if (const Mask missed = at_light & e.missed; any(missed)) add_environment(batch, e, missed);
    const Mask scattered = and_not(e.met, at_light);
    if (none(e.met)) {
      frontier_.drop(k);
      continue;
    }
    e.find_surface(scene_, e.on_surface);
    add_emission(batch, e, e.on_surface & at_light);
    if (none(scattered)) {
      frontier_.drop(k);
      continue;
    }
    e.choice = e.random(dimension::kChoice);
    e.find_scattering(scene_);
    disperse_at(scene_, v, e.met, e.path);
    e.weights = arrive_at(scene_, v, depth, e.reference.p, e.numbers.get_2d(dimension::kLens),
                          e.path.wavelengths, film_area_, e.weights, scattered);
    if (const Mask joined = joinable(v, scattered & ends); any(joined)) {
      sample_one_light(batch, e, joined & (from_light == 1));
      for (int event = 0; event < kept_.events(); ++event) {
        const LightVertex* const y = kept_.at(event, k);
        if (y == nullptr) continue;
        if (const Mask both = joined & (from_light == event + 2) & y->joinable; any(both))
          join(batch, e, *y, event, both);
      }
    }
    scatter_from_eye(e, and_not(scattered, ends));
  }
  frontier_.end_step();
}

void PathMaker::add_environment(PathBatch& batch, const Event& e, Mask missed) {
  const Vec3 direction = e.path.direction;
  Spectrum sum(0.0f);
  for (const std::int32_t number : scene_.lights.infinite_lights) {
    const Int light(number);
    const Spectrum radiance =
        environment_light(scene_, spectra_of(scene_, e.path), number, e.reference, direction, missed);
    sum += radiance * weight_of_hit(scene_, e.weights, e.reference, direction, light, missed);
  }
  add(batch, sum * e.path.beta * scale_of(batch, e.packet, true), e.packet, missed);
}

void PathMaker::add_emission(PathBatch& batch, const Event& e, Mask hit) {
  const Surface& surface = e.vertex.surface;
  const Mask lit = hit & (surface.light >= 0);
  if (none(lit)) return;
  const Spectrum radiance = emitted_light(scene_, spectra_of(scene_, e.path), surface, e.vertex.wo, lit);
  const Float weight =
      weight_of_hit(scene_, e.weights, e.reference, e.path.direction, surface.light, surface.p, surface.ng,
                    dot(surface.ng, e.vertex.wo), length_squared(surface.p - e.reference.p), lit);
  const Float scale = weight * scale_of(batch, e.packet, true);
  add(batch, radiance * e.path.beta * scale, e.packet, lit);
}

void PathMaker::sample_one_light(PathBatch& batch, const Event& e, Mask wanted) {
  if (!samples_lights(scene_.lights) || none(wanted)) return;
  const Vec2 u_point = e.random(dimension::kLightPoint);
  queue(
      batch, e,
      light_of(scene_, e.end(),
               choose_light(scene_.lights, receiver_at(scene_, e.vertex), u_point, e.choice.x, wanted), true),
      0);
}

void PathMaker::join(PathBatch& batch, const Event& e, const LightVertex& y, int event, Mask wanted) {
  queue(batch, e, light_of(scene_, e.end(), y, 1.0f, Float(0.0f), true, wanted), join_salt(event));
}

void PathMaker::queue(const PathBatch& batch, const Event& e, WayLight way, std::uint32_t salt) {
  if (none(way.shines)) return;
  way.ray.contribution = way.unweighted * (way.weight * scale_of(batch, e.packet, true));
  if (scene_.volumetric) way.ray.wavelengths = e.path.wavelengths;
  queue(batch, way.ray, e.path.slot, salt, and_not(way.shines, is_black(way.ray.contribution)));
}

void PathMaker::scatter_from_eye(const Event& e, Mask hit) {
  if (none(hit)) {
    frontier_.drop(e.packet);
    return;
  }
  const EyeStep step =
      step_from_eye(scene_, e.end(), e.path, e.choice.y, e.random(dimension::kBsdfDirection), hit);
  weights_.store(step.weights, e.packet);
  frontier_.replace(scene_, e.packet, step.next, step.alive);
}

}  // namespace tessera::render::TESSERA_ISA
