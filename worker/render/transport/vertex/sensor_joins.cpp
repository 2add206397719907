#include "render/transport/vertex/sensor_joins.h"

#include <algorithm>
#include <bit>

#include "render/film/summable.h"
#include "render/integrator/stage_timer.h"
#include "render/sensor/respond.h"
#include "render/sensor/shutter.h"
#include "render/transport/vertex/dispersion.h"
#include "render/transport/vertex/film_reach.h"
#include "render/transport/vertex/light_start.h"

namespace tessera::render::TESSERA_ISA {

SensorJoin sensor_join(const SceneTables& scene, const Vertex& v, Spectrum beta, Int dispersed,
                       const Wavelengths& wavelengths, Vec2 u_lens, const FilmRect& rect, Mask wanted) {
  SensorJoin join;
  join.eye = connect_to_sensor(scene.sensor, v.surface.p, u_lens, v.time, wanted,
                               first_wavelength(wavelengths, Float(kMiddleNm)));
  join.seen = wanted & join.eye.valid & lands(scene, join.eye.raster, rect);
  if (none(join.seen)) return join;
  const Vec3 to_eye = join.eye.lens - v.surface.p;
  const Float distance = length(to_eye);
  join.w = to_eye * (1.0f / max(distance, 1e-30f));
  // Radiance towards the eye of light that comes from where the path comes from; the cosine at the light's
  // side is the shading normal's, so the geometric one takes its place.
  join.back = eval_scattering(scene, v, join.w, v.wo, join.seen);
  const Float geometry =
      join.eye.importance * abs(dot(join.w, v.surface.ng)) / max(abs(dot(v.wo, v.surface.ng)), 1e-6f);
  if (kSpectral && scene.sensor.disperses) beta = first_for_all(dispersed == 0, beta);
  join.value = beta * join.back.f_cos *
               (select(v.in_medium, join.eye.importance, geometry) * scene.sensor.response.exposure);
  if (scene.any_motion && scene.sensor.shutter)
    join.value *= exposure_at(scene.sensor, join.eye.raster, v.time);
  return join;
}

WideConnection ray_of(const SceneTables& scene, const Vertex& v, const SensorJoin& join, Mask& shines) {
  shines = and_not(shines, is_black(join.value));
  for (int c = 0; c < kSpectrumLanes; ++c) shines &= is_summable(join.value.c[c]);
  WideConnection ray = connect(scene, v, join.w, join.eye.lens, shines);
  // Things before the near plane are not seen, and block nothing.
  ray.distance = ray.distance * join.eye.open_part;
  ray.contribution = join.value;
  return ray;
}

void SensorJoins::add(const Vertex& v, const SensorJoin& join, UInt key, const Wavelengths& wavelengths,
                      Mask shines) {
  WideConnection ray = ray_of(scene_, v, join, shines);
  ray.key = bit_cast<std::int32_t>(key);
  ray.layers = join.layers;
  ray.inverse_weight = join.inverse_weight;
  ray.wavelengths = wavelengths;
  add(ray, join.eye.raster, shines);
}

void SensorJoins::add(const WideConnection& ray, Vec2 raster, Mask shines) {
  const int at = connections_.size;
  compress_store(raster.x, shines, film_x_ + at);
  compress_store(raster.y, shines, film_y_ + at);
  if constexpr (kSpectral) append_lanes(ray.wavelengths, shines, wavelengths_, at);
  connections_.size += append(scene_, ray, shines, connections_, at);
  for (int i = at; i < connections_.size; ++i) connections_.slot[i] = i;
}

template <class Place, class Lane>
void SensorJoins::splat_bands(const Wavelengths& wavelengths, const Channels& channels, std::uint32_t arrived,
                              Place&& place, Lane&& lane) {
#ifdef TESSERA_SPECTRAL
  const SensitivityTable& sensor = scene_.sensor.response.sensitivity;
  if (sensor.bands == 0) return;
  for (int i = 0; i < kSpectrumLanes; ++i) {
    const BandShare share = band_share(sensor, wavelengths, channels, i);
    const Float light = lane(i) * share.weight;
    for (std::uint32_t bits = arrived & (share.band >= 0).bits(); bits != 0; bits &= bits - 1) {
      const int k = std::countr_zero(bits), at = place(k);
      band_splats_.push_back({film_x_[at], film_y_[at], light.lane(k), share.band.lane(k)});
    }
  }
#else
  (void)wavelengths, (void)channels, (void)arrived, (void)place, (void)lane;
#endif
}

void SensorJoins::trace(Film& film) {
  const StageTimer timer(stats_.times, Stage::kShadow);
  splats_.clear(), band_splats_.clear();
  if (scene_.volumetric) {
    transit_.march(Passenger::kPath, connections_, hits_, 0, [&](const WideConnection& ray, Mask arrived) {
      const Channels channels = channels_of_light(scene_.sensor.response, ray.wavelengths);
      const Color light = color_of([&](int channel) {
        return channels.of(channel, [&](int lane) { return ray.contribution.c[lane]; });
      });
      for (std::uint32_t bits = arrived.bits(); bits != 0; bits &= bits - 1) {
        const int lane = __builtin_ctz(bits);
        splat(ray.slot.lane(lane), {light.c[0].lane(lane), light.c[1].lane(lane), light.c[2].lane(lane)},
              scene_.layers.count > 0 ? ray.layers.lane(lane) : 0,
              scene_.layers.unweighted != 0 ? ray.inverse_weight.lane(lane) : 1);
      }
      splat_bands(
          ray.wavelengths, channels, arrived.bits(), [&](int k) { return ray.slot.lane(k); },
          [&](int lane) { return ray.contribution.c[lane]; });
    });
  } else {
    const float* const times = scene_.any_motion ? connections_.time : nullptr;
    rays_.occluded(arrays_of(connections_.origin, connections_.direction, times), connections_.size,
                   connections_.distance);
    stats_.shadow_rays += static_cast<std::uint64_t>(connections_.size);
    for (int first = 0; first < connections_.size; first += kWidth) {
      Wavelengths wavelengths;
      load_lanes(wavelengths_, first, wavelengths);
      const Channels channels = channels_of_light(scene_.sensor.response, wavelengths);
      alignas(64) float light[kResponseChannels][kWidth];
      const auto lane_of = [&](int lane) { return Float::load(connections_.contribution.c[lane] + first); };
      for (int channel = 0; channel < kResponseChannels; ++channel)
        channels.of(channel, lane_of).store(light[channel]);
      const Mask blocked = Float::load(connections_.distance + first) < 0.0f;
      splat_bands(
          wavelengths, channels, and_not(Mask::first(connections_.size - first), blocked).bits(),
          [&](int k) { return first + k; }, lane_of);
      for (int i = first; i < std::min(first + kWidth, connections_.size); ++i) {
        if (connections_.distance[i] < 0) continue;
        splat(i, {light[0][i - first], light[1][i - first], light[2][i - first]},
              scene_.layers.count > 0 ? connections_.layers[i] : 0,
              scene_.layers.unweighted != 0 ? connections_.inverse_weight[i] : 1);
      }
    }
    connections_.size = 0;
  }
  film.splat(splats_);
  if (!band_splats_.empty()) film.splat_bands(band_splats_);
}

void SensorJoins::splat(int place, const std::array<float, kResponseChannels>& light, std::int32_t layers,
                        float inverse_weight) {
  Splat splat{film_x_[place], film_y_[place], {light[0], light[1], light[2]}};
  splat.layers = static_cast<std::uint32_t>(layers & ~scene_.layers.unweighted);
  splats_.push_back(splat);
  const std::int32_t apart = layers & scene_.layers.unweighted;
  if (apart == 0) return;
  for (float& value : splat.value) value *= inverse_weight;
  splat.layers = static_cast<std::uint32_t>(apart);
  splat.in_picture = false;
  splats_.push_back(splat);
}

}  // namespace tessera::render::TESSERA_ISA
