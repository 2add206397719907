#include "render/integrator/light/light_tracer.h"

#include <algorithm>

#include "render/integrator/vertex/dimensions.h"
#include "render/integrator/vertex/layers.h"
#include "render/integrator/vertex/light_start.h"
#include "render/integrator/vertex/roulette.h"

namespace tessera::render::TESSERA_ISA {

/// Sixteen paths at a surface.
struct LightTracer::Event {
  WidePath path;
  Sampler sampler;
  int depth;       // events before this one
  int first_pair;  // of this event's dimensions
  Vertex vertex;   // its wo points back to the light

  // The vertex is large and filled in later: it is not zeroed.
  Event(const WidePath& wide_path, const Sampler& numbers, int number)
      : path(wide_path),
        sampler(numbers),
        depth(number),
        first_pair(dimension::kFirstLightEvent + number * dimension::kPairsPerLightEvent) {}
};

bool LightTracer::render(SampleSource& work, Film& film, std::stop_token stop) {
  if (!eye_.render(work, film, stop)) return false;
  if (!emits_paths(scene_) || scene_.max_depth == 0) return true;
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
    hash.store(keys_.pixel_hash + slot);
    reversed.store(keys_.reversed_sample + slot);
    const Sampler sampler(scene_.sampler.kind, hash, reversed);
    const float paths = static_cast<float>(scene_.camera.width) * static_cast<float>(scene_.camera.height);
    LightStart start = start_at_light(scene_, sampler, paths, Int::iota(slot), active);
    if (tells_layers(scene_))
      start.path.layer_state = state_at_light(scene_.layers, start.light, start.alive);
    alive_ += append(scene_, start.path, start.alive, paths_, alive_);
  }
  stats_.samples += static_cast<std::uint64_t>(count);
}

void LightTracer::advance(int depth, Film& film) {
  intersect();
  shade(depth, film.rect());
  joins_.trace(film);
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
    const Hit found = load_hit(hits_, i);
    const Mask hit = active & (found.shape >= 0);
    if (none(hit)) continue;
    const WidePath path = load(scene_, paths_, i);
    Event e(path, keys_.sampler(scene_.sampler.kind, path.slot, active), depth);
    meet_surface(scene_, path, found, e.sampler, e.first_pair, hit, e.vertex);
    join_to_camera(e, hit, rect);
    if (depth + 1 < scene_.max_depth) scatter_paths(e, hit, kept);
  }
  alive_ = kept;
}

void LightTracer::join_to_camera(const Event& e, Mask hit, const FilmRect& rect) {
  const Mask wanted = joinable(e.vertex, hit);
  if (none(wanted)) return;
  const Vec2 lens = e.sampler.get_2d(e.first_pair + dimension::kJoinLens);
  CameraJoin join = camera_join(scene_, e.vertex, e.path.beta, lens, rect, wanted);
  if (none(join.seen)) return;
  if (tells_layers(scene_)) {
    const Int state = state_after(scene_, e.vertex, e.path.layer_state, join.w, e.vertex.wo, Mask::none(),
                                  {e.sampler, e.depth, true}, join.seen);
    join.layers = layers_at_eye(scene_.layers, state, join.seen);
  }
  joins_.add(e.vertex, join, UInt(0), join.seen);
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
  if (tells_layers(scene_)) {
    next.layer_state = state_after(scene_, v, e.path.layer_state, bsdf.wi, v.wo, bsdf.specular,
                                   {e.sampler, e.depth, false}, alive);
  }
  alive &= survive_roulette(next.beta, next.roulette_scale,
                            e.sampler.get_2d(e.first_pair + dimension::kLightRoulette).x);

  // Entries are read 16 at a time before they are overwritten, and never move up.
  kept += append(scene_, next, alive, paths_, kept);
}

}  // namespace tessera::render::TESSERA_ISA
