#include "render/integrator/light/light_tracer.h"

#include <algorithm>

#include "render/camera/camera.h"
#include "render/film/summable.h"
#include "render/integrator/vertex/dimensions.h"
#include "render/integrator/vertex/roulette.h"
#include "render/light/emission.h"
#include "render/sampling/discrete.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// Cosines with shading and geometric normal do not cancel as they do on a path from the eye [Veach 1997,
/// section 5.3].
Float normal_ratio(const Surface& s, const Frame& frame, Vec3 from, Vec3 to) {
  const Float in = abs(dot(from, frame.z)) / max(abs(dot(from, s.ng)), 1e-6f);
  return in * abs(dot(to, s.ng)) / max(abs(dot(to, frame.z)), 1e-6f);
}

}  // namespace

/// Sixteen paths at a surface.
struct LightTracer::Event {
  WidePath path;
  Sampler sampler;
  int first_pair;  // of this event's dimensions
  Vertex vertex;   // its wo points back to the light

  // The vertex is large and filled in later: it is not zeroed.
  Event(const WidePath& wide_path, const Sampler& numbers, int pair)
      : path(wide_path), sampler(numbers), first_pair(pair) {}
};

bool LightTracer::render(SampleSource& work, Film& film, std::stop_token stop) {
  if (!eye_.render(work, film, stop)) return false;
  if (scene_.lights.selection.threshold.empty() || scene_.max_depth == 0) return true;
  const std::int32_t paths = scene_.camera.width * scene_.camera.height;
  for (std::int32_t first = 0; first < paths; first += kBatch) {
    if (stop.stop_requested()) return false;
    start_paths(first, std::min<std::int32_t>(kBatch, paths - first), work.pass());
    for (int depth = 0; alive_ > 0; ++depth) advance(depth, film);
  }
  return true;
}

void LightTracer::start_paths(std::int32_t first, std::int32_t count, std::uint32_t pass) {
  const StageTimer timer(stats_.times, Stage::kCamera);
  alive_ = 0;
  const UInt reversed = reverse_bits(UInt(pass));
  for (std::int32_t slot = 0; slot < count; slot += kWidth) {
    const Mask active = Mask::first(count - slot);
    // A path belongs to a pixel, if only by its random numbers.
    const Int index = Int::iota(first + slot);
    const UInt hash = Sampler::pixel_hash(seed_, bit_cast<std::uint32_t>(index), UInt(0x4c696768u));
    hash.store(pixel_hash_ + slot);
    reversed.store(reversed_sample_ + slot);
    const Sampler sampler(scene_.sampler.kind, hash, reversed);

    const DiscreteSample choice =
        sample_discrete(scene_.lights.selection, sampler.get_2d(dimension::kEmitter).x, active);
    const Emission ray =
        sample_emission(scene_.lights, choice.index, sampler.get_2d(dimension::kEmissionPlace),
                        sampler.get_2d(dimension::kEmissionDirection), active);
    const Mask alive = active & ray.valid & (choice.pmf > 0.0f);
    const Float scale = 1.0f / (select(alive, choice.pmf, 1.0f) * static_cast<float>(scene_.camera.width) *
                                static_cast<float>(scene_.camera.height));
    WidePath path{};
    path.origin = ray.origin + ray.offset;
    path.direction = ray.direction;
    path.beta = ray.flux * scale;
    path.roulette_scale = 1.0f / max(path.beta.max_component(), 1e-30f);
    path.slot = Int::iota(slot);
    if (scene_.any_motion) path.time = sampler.get_2d(dimension::kTime).x;
    alive_ += append(scene_, path, alive, paths_, alive_);
  }
  stats_.samples += static_cast<std::uint64_t>(count);
}

void LightTracer::advance(int depth, Film& film) {
  intersect();
  shade(depth, film.rect());
  trace_connections(film);
}

void LightTracer::intersect() {
  const StageTimer timer(stats_.times, Stage::kIntersection);
  stats_.bounce_rays += static_cast<std::uint64_t>(alive_);
  rays_.nearest(arrays_of(paths_.origin, paths_.direction, times_of(paths_.time)), alive_, false,
                hits_.arrays());
}

void LightTracer::shade(int depth, const FilmRect& rect) {
  const StageTimer timer(stats_.times, Stage::kShading);
  int kept = 0;
  for (int i = 0; i < alive_; i += kWidth) {
    const Mask active = Mask::first(alive_ - i);
    Hit found = load_hit(hits_, i);
    const Mask hit = active & (found.shape >= 0);
    if (none(hit)) continue;
    const WidePath path = load(scene_, paths_, i);
    if (scene_.any_motion) found.time = path.time;
    Event e(path,
            {scene_.sampler.kind, gather(pixel_hash_, path.slot, active),
             gather(reversed_sample_, path.slot, active)},
            dimension::kFirstLightEvent + depth * dimension::kPairsPerLightEvent);
    Vertex& v = e.vertex;
    v.wo = -path.direction;
    v.time = found.time;
    v.surface = surface_at(scene_.shapes, found, path.origin, path.direction, hit, scene_.any_tangents);
    interact(scene_, v.surface, v.wo, e.sampler.get_2d(e.first_pair + dimension::kLightRoulette).y, hit,
             v.at);
    if (scene_.any_opacity) {
      if (const Mask partly = partly_open(v, hit); any(partly)) {
        open_surface(scene_, e.sampler.get_2d(e.first_pair + dimension::kLobe).y, partly, v);
      }
    }
    join_to_camera(e, hit, rect);
    if (depth + 1 < scene_.max_depth) scatter_paths(e, hit, kept);
  }
  alive_ = kept;
}

void LightTracer::join_to_camera(const Event& e, Mask hit, const FilmRect& rect) {
  const Vertex& v = e.vertex;
  const Mask wanted = joinable(v, hit);
  if (none(wanted)) return;
  const CameraConnection eye = connect_to_camera(
      scene_.camera, v.surface.p, e.sampler.get_2d(e.first_pair + dimension::kJoinLens), v.time, wanted);
  const Mask seen = wanted & eye.valid & lands(eye.film, rect);
  if (none(seen)) return;
  const Vec3 to_eye = eye.lens - v.surface.p;
  const Float distance = length(to_eye);
  const Vec3 w = to_eye * (1.0f / max(distance, 1e-30f));
  // Radiance towards the eye of light that comes from where the path comes from; the cosine at the light's
  // side is the shading normal's, so the geometric one takes its place.
  const BsdfEval bsdf = eval_bsdf(v.at, w, v.wo, seen);
  const Float geometry =
      eye.importance * abs(dot(w, v.surface.ng)) / max(abs(dot(v.wo, v.surface.ng)), 1e-6f);
  const Spectrum value = e.path.beta * bsdf.f_cos * (geometry * scene_.exposure);
  Mask shines = and_not(seen, is_black(value));
  for (int c = 0; c < kSpectrumLanes; ++c) shines &= is_summable(value.c[c]);

  WideConnection ray = connect(scene_, v, w, eye.lens, shines);
  // Things before the near plane are not seen, and block nothing.
  const float near_clip = scene_.camera.near_clip;
  if (near_clip > 0) ray.distance = ray.distance * (1.0f - near_clip / max(eye.depth, 1e-30f));
  ray.contribution = value;
  ray.slot = e.path.slot;
  const int at = connections_.size;
  compress_store(eye.film.x, shines, film_x_ + at);
  compress_store(eye.film.y, shines, film_y_ + at);
  connections_.size += append(scene_, ray, shines, connections_, at);
}

Mask LightTracer::lands(Vec2 film, const FilmRect& rect) const {
  const float rx = scene_.filter.x.radius, ry = scene_.filter.y.radius;
  return (film.x > static_cast<float>(rect.x0) - rx) & (film.x < static_cast<float>(rect.x1) + rx) &
         (film.y > static_cast<float>(rect.y0) - ry) & (film.y < static_cast<float>(rect.y1) + ry);
}

void LightTracer::scatter_paths(const Event& e, Mask hit, int& kept) {
  const Vertex& v = e.vertex;
  const BsdfSample bsdf = sample_bsdf(v.at, v.wo, e.sampler.get_2d(e.first_pair + dimension::kLobe).x,
                                      e.sampler.get_2d(e.first_pair + dimension::kLightBsdfDirection), hit,
                                      Transport::kImportance);
  const Float normals = normal_ratio(v.surface, v.at.frame, v.wo, bsdf.wi);
  WidePath next = e.path;
  next.origin = offset_origin(v.surface, bsdf.wi);
  next.direction = bsdf.wi;
  next.beta = e.path.beta * bsdf.weight * normals;
  Mask alive = and_not(hit & bsdf.valid & is_finite(next.beta), is_black(next.beta));
  alive &= survive_roulette(next.beta, next.roulette_scale,
                            e.sampler.get_2d(e.first_pair + dimension::kLightRoulette).x);

  // Entries are read 16 at a time before they are overwritten, and never move up.
  kept += append(scene_, next, alive, paths_, kept);
}

void LightTracer::trace_connections(Film& film) {
  const StageTimer timer(stats_.times, Stage::kShadow);
  rays_.occluded(arrays_of(connections_.origin, connections_.direction, times_of(connections_.time)),
                 connections_.size, connections_.distance);
  stats_.shadow_rays += static_cast<std::uint64_t>(connections_.size);
  splats_.clear();
  for (int i = 0; i < connections_.size; ++i) {
    if (connections_.distance[i] < 0) continue;
    const auto light = [&](int band) {
      return band_mean(band, [&](int lane) { return connections_.contribution.c[lane][i]; });
    };
    splats_.push_back({film_x_[i], film_y_[i], {light(0), light(1), light(2)}});
  }
  connections_.size = 0;
  film.splat(splats_);
}

}  // namespace tessera::render::TESSERA_ISA
