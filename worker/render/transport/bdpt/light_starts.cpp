#include "render/transport/bdpt/light_starts.h"

#include "render/transport/vertex/light_end.h"
#include "render/transport/vertex/medium_at.h"

namespace tessera::render::TESSERA_ISA {

void LightStarts::add(int packet, LightStart& start) {
  start.light.store(light_ + packet * kWidth);
  store_lanes(start.ray.origin, point_, packet * kWidth);
  store_lanes(start.ray.normal, normal_, packet * kWidth);
  if (!scene_.volumetric) return;
  start.path.reference = start.ray.origin;
  start.path.medium = Int(-1);
  ways_.size +=
      append(scene_, way_from_sensor(scene_, start.path.origin, start.path.time, Int::iota(packet * kWidth)),
             start.alive, ways_, ways_.size);
}

void LightStarts::enter_media(Frontier& frontier) {
  if (scene_.media.media.empty()) return;
  find_media(context_, ways_, frontier.hits, media_);
  PathState& paths = frontier.paths;
  for (int k = 0; k < kPackets; ++k) {
    const Mask active = frontier.lanes(k);
    if (none(active)) continue;
    const Int entry = frontier.entries(k), light = Int::load(light_ + k * kWidth);
    const Vec3 direction = gather_lanes<Vec3>(paths.direction, entry, active);
    Vec3 point;
    load_lanes(point_, k * kWidth, point);
    const Int medium =
        medium_at_light(scene_, light, point, direction, Int::load(media_ + k * kWidth), active);
    scatter(medium, paths.medium, entry, active);
    if (const Mask lost = is_lost(scene_, light, medium, active); any(lost))
      scatter_lanes(Spectrum(0.0f), paths.beta, entry, lost);
  }
}

PartialWeights LightStarts::first_weights(int packet, const Vertex& v, Mask hit) const {
  const Int light = Int::load(light_ + packet * kWidth);
  Vec3 point, normal;
  load_lanes(point_, packet * kWidth, point);
  load_lanes(normal_, packet * kWidth, normal);
  const Mask flat = length_squared(normal) > 0.0f;
  const Float pdf = sampling_density(scene_.lights, light, receiver_at(scene_, v), v.wo, point, normal, hit);
  const Float light_cosine = select(flat, dot(normal, -v.wo), 1.0f);
  return light_end(scene_.lights, light, v.time, pdf, point, light_cosine, -v.wo,
                   length_squared(v.surface.p - point), hit)
      .first_vertex(cosine_at(v, v.wo));
}

}  // namespace tessera::render::TESSERA_ISA
