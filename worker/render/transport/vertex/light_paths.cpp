#include "render/transport/vertex/light_paths.h"

#include "render/transport/vertex/dispersion.h"
#include "render/transport/vertex/focused.h"
#include "render/transport/vertex/layers.h"
#include "render/transport/vertex/light_end.h"
#include "render/transport/vertex/roulette.h"

namespace tessera::render::TESSERA_ISA {

void LightPaths::start(std::int32_t first, std::int32_t count, std::uint32_t pass, const PassShare& shared) {
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
    LightStart start = start_at_light(scene_, sampler, paths_of_pass_, Int::iota(slot), active, shared);
    start.path.pdf =
        select(delta_lights(scene_.lights, start.light, start.alive), Float(kMirrored), Float(kBundled));
    if (tells_layers(scene_))
      start.path.layer_state = state_at_light(scene_.layers, start.light, start.alive);
    alive_ += append(scene_, start.path, start.alive, paths_, alive_);
  }
  stats_.samples += static_cast<std::uint64_t>(count);
}

void LightPaths::intersect() {
  const StageTimer timer(stats_.times, Stage::kIntersection);
  stats_.bounce_rays += static_cast<std::uint64_t>(alive_);
  const float* const times = scene_.any_motion ? paths_.time : nullptr;
  rays_.nearest(arrays_of(paths_.origin, paths_.direction, times), alive_, false, hits_.arrays());
}

int LightPaths::scatter(const LightEvent& e, Mask hit, int kept) {
  const Vertex& v = e.vertex;
  const BsdfSample bsdf = sample_bsdf(v.at, v.wo, e.sampler.get_2d(e.first_pair + dimension::kLobe).x,
                                      e.sampler.get_2d(e.first_pair + dimension::kLightBsdfDirection), hit,
                                      Transport::kImportance);
  const Float normals = normal_ratio(v.surface, v.at.frame, v.wo, bsdf.wi);
  WidePath next = e.path;
  next.origin = offset_origin(v.surface, bsdf.wi);
  next.direction = bsdf.wi;
  const Mask bundled = is_focused(bsdf.pdf) & (e.path.pdf != kScattered);
  next.pdf = select(bsdf.specular, e.path.pdf, select(bundled, Float(kBundled), Float(kScattered)));
  next.beta = e.path.beta * bsdf.weight * normals;
  disperse_along(scene_, v, bsdf, next);
  Mask alive = and_not(hit & bsdf.valid & is_finite(next.beta), is_black(next.beta));
  if (tells_layers(scene_)) {
    next.layer_state = light_state_after(scene_, v, e.path.layer_state, bsdf.wi, v.wo, bsdf.specular,
                                         {e.sampler, e.depth, false}, alive);
  }
  alive &= survive_roulette(next.beta, next.roulette_scale,
                            e.sampler.get_2d(e.first_pair + dimension::kLightRoulette).x);

  // Entries are read 16 at a time before they are overwritten, and never move up.
  return kept + append(scene_, next, alive, paths_, kept);
}

}  // namespace tessera::render::TESSERA_ISA
