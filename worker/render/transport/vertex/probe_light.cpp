#include "render/transport/vertex/probe_light.h"

#include "render/sensor/probe.h"
#include "render/sensor/probe_table.h"
#include "render/transport/vertex/dimensions.h"
#include "render/transport/vertex/layers.h"
#include "render/transport/vertex/light_choice.h"
#include "render/transport/vertex/light_spectrum.h"
#include "render/transport/vertex/power_heuristic.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// Light from a direction that a probe weighs.
struct ArrivingLight {
  Vec3 origin, direction;  // of the ray back to the light
  Float distance;
  Int light;
  Color radiance;
  Float factor;  // importance over density, weighed against rays of the sensor
  Mask shines;
};

ArrivingLight light_around(const SceneTables& scene, const ProbeRecord& probe, const WidePath& path,
                           Vec3 axis, Vec2 u_point, Float u_choice, Mask wanted) {
  Receiver receiver(path.origin, path.normal);
  receiver.time = path.time;
  const LightChoice choice = choose_light(scene.lights, receiver, u_point, u_choice, wanted);
  const LightSample& sample = choice.sample;
  const Mask lit = choice.pick.picked & sample.valid;
  const Float pdf = sample.pdf * choice.pick.pmf;
  const ProbeWeight weight = weigh_at_probe(probe, axis, sample.wi);
  const Float share = select(sample.delta, Float(1.0f), power_heuristic(pdf, weight.pdf));
  return {path.origin,
          sample.wi,
          sample.distance,
          choice.pick.light,
          sample.radiance,
          weight.importance * share / select(lit, pdf, 1.0f),
          lit & (weight.importance > 0.0f)};
}

/// From far away only lights at one point are found here: rays of the sensor meet all others that it sees. A
/// light's intensity is what it sends to a point on the axis times the squared distance to there.
ArrivingLight light_from_afar(const SceneTables& scene, const ProbeRecord& probe, const WidePath& path,
                              Vec2 u_point, Float u_choice, Mask wanted) {
  const Vec3 axis{Float(probe.axis[0]), Float(probe.axis[1]), Float(probe.axis[2])};
  const Vec3 middle{Float(probe.origin[0]), Float(probe.origin[1]), Float(probe.origin[2])};
  const Float away(probe.offset);
  Receiver receiver(fma(axis, away, middle));
  receiver.time = path.time;
  const LightChoice choice = choose_light(scene.lights, receiver, u_point, u_choice, wanted);
  const Float reach = 4.0f * (away + probe.radius);
  const Mask at_point =
      choice.pick.picked & choice.sample.valid & choice.sample.delta & (choice.sample.distance < reach);
  const Vec3 light = fma(choice.sample.wi, choice.sample.distance, receiver.p);
  receiver.p = fma(axis, away, light);
  const LightSample sample = sample_light(scene.lights, choice.pick.light, receiver, u_point, at_point);
  const Mask lit = at_point & sample.valid;
  return {receiver.p,
          sample.wi,
          sample.distance,
          choice.pick.light,
          sample.radiance,
          sqr(away) / select(lit, choice.pick.pmf, 1.0f),
          lit};
}

}  // namespace

void append_probe_light(const SceneTables& scene, UInt x, UInt y, const Sampler& sampler, UInt key,
                        Mask active, WidePath& path, ConnectionQueue& queue) {
  const Vec3 axis = path.normal;
  const Vec3 none_known{Float(0.0f), Float(0.0f), Float(0.0f)};
  path.normal = none_known;
  const Int probes = probe_of_pixels(scene.sensor, x, y, active);
  const Mask reading = active & (probes >= 0);
  if (!samples_lights(scene.lights) || none(reading)) return;
  const Vec2 u_point = sampler.get_2d(dimension::kProbeLight);
  const Float u_choice = sampler.get_2d(dimension::kProbeLightChoice).x;
  for_each_distinct(probes, reading, [&](std::int32_t number, Mask lanes) {
    const ProbeRecord& probe = scene.sensor.probes->probes[static_cast<std::size_t>(number)];
    if (!samples_lights(probe)) return;
    if (probe.kind == ProbeKind::kPlane) path.normal = select(lanes, axis, path.normal);
    const ArrivingLight light = probe.kind == ProbeKind::kFarField
                                    ? light_from_afar(scene, probe, path, u_point, u_choice, lanes)
                                    : light_around(scene, probe, path, axis, u_point, u_choice, lanes);
    WideConnection ray{};
    ray.origin = light.origin, ray.direction = light.direction, ray.distance = light.distance;
    ray.contribution =
        spectrum_of_light(scene, spectra_of(scene, path), light.light, light.radiance, light.shines) *
        light.factor;
    ray.slot = path.slot;
    ray.time = path.time;
    ray.medium = path.medium;
    ray.key = bit_cast<std::int32_t>(key);
    ray.wavelengths = path.wavelengths;
    const Mask shines = and_not(light.shines, is_black(ray.contribution));
    ray.layers =
        tells_layers(scene) ? layers_at_light(scene.layers, path.layer_state, light.light, shines) : Int(0);
    queue.size += append(scene, ray, shines, queue, queue.size);
  });
}

}  // namespace tessera::render::TESSERA_ISA
