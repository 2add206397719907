// Light that paths come to, as the samples of lights that could have found it weigh it, and those samples.
#pragma once

#include "render/light/area/interpolated_normal.h"
#include "render/light/selection/pick.h"
#include "render/transport/vertex/light_spectrum.h"
#include "render/transport/vertex/path_observer.h"
#include "render/transport/vertex/power_heuristic.h"

namespace tessera::render::TESSERA_ISA {

/// Weighs it in the lanes of `weighed` by the power heuristic; `point` and `normal` are those of a lamp.
TESSERA_INLINE void weigh(const SceneTables& scene, const Encounter& e, Vec3 point, Vec3 normal,
                          MetLight& light) {
  light.arriving = light.radiance;
  if (none(light.weighed)) return;
  light.by_lights =
      light_pdf(scene.lights, light.light, e.reference, e.path.direction, point, normal, light.weighed) *
      pick_pmf(scene.lights, light.light, e.reference, light.weighed);
  light.arriving *= select(light.weighed, power_heuristic(e.path.pdf, light.by_lights), 1.0f);
}

/// Multiplies light of lamps by interpolated_normal_factor().
TESSERA_INLINE void interpolate_normals(const SceneTables& scene, const Encounter& e, MetLight& light) {
  if (!scene.lights.any_interpolated) return;
  const Surface& surface = e.vertex.surface;
  light.arriving *= interpolated_normal_factor(scene.lights, light.light, surface, e.vertex.wo,
                                               length(surface.p - e.reference.p), e.path.pdf, light.lanes);
}
TESSERA_INLINE void interpolate_normals(const SceneTables& scene, const Encounter& e, Float bsdf_pdf,
                                        SampledLight& light) {
  if (!scene.lights.any_interpolated) return;
  light.ray.contribution *= interpolated_normal_factor(scene.lights, light.light, e.vertex.surface.p,
                                                       light.sample, bsdf_pdf, light.lanes);
}

/// Light of surfaces in the lanes `lit`, which emit some; `weighed` as in MetLight.
TESSERA_INLINE MetLight lamps_met(const SceneTables& scene, const Encounter& e, Mask lit, Mask weighed) {
  const Surface& surface = e.vertex.surface;
  MetLight light{.light = surface.light,
                 .at_infinity = false,
                 .lanes = lit,
                 .radiance = emitted_light(scene, spectra_of(scene, e.path), surface, e.vertex.wo, lit),
                 .weighed = weighed};
  weigh(scene, e, surface.p, surface.ng, light);
  return light;
}

/// Light of an infinite light that comes to `e.missed`.
TESSERA_INLINE MetLight sky_met(const SceneTables& scene, const Encounter& e, std::int32_t number,
                                Mask weighed) {
  MetLight light{.light = Int(number),
                 .at_infinity = true,
                 .lanes = e.missed,
                 .radiance = environment_light(scene, spectra_of(scene, e.path), number, e.reference,
                                               e.path.direction, e.missed),
                 .weighed = weighed};
  weigh(scene, e, e.reference.p, e.path.direction, light);
  return light;
}

/// Light that comes to the encounter by `sample` if nothing is between; `f_cos` as in BsdfEval. The ray ends
/// just before the light: the offset of a large surface may exceed the light's own margin, and would then
/// make the light shadow itself.
TESSERA_INLINE SampledLight light_sampled(const SceneTables& scene, const SampleBatch& batch,
                                          const Encounter& e, Int light, const LightSample& sample, Float pdf,
                                          Float weight, Spectrum f_cos, Mask lanes) {
  const Vec3 end = fma(sample.wi, sample.distance, e.vertex.surface.p);
  SampledLight result{
      .light = light,
      .sample = sample,
      .radiance = spectrum_of_light(scene, spectra_of(scene, e.path), light, sample.radiance, lanes),
      .pdf = pdf,
      .weight = weight,
      .lanes = lanes,
      .ray = connect(scene, e.vertex, sample.wi, end, lanes)};
  result.ray.contribution = e.path.beta * f_cos * result.radiance * (weight / select(lanes, pdf, 1.0f));
  if (scene.volumetric) result.ray.wavelengths = e.path.wavelengths;
  batch.name(result.ray, e.path.slot, lanes);
  return result;
}

}  // namespace tessera::render::TESSERA_ISA
