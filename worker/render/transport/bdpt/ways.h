// The ways in which light gets into a subpath from the eye, for algorithms that weigh all of them: a light
// that it hits, one that shines on its vertex, a vertex of a subpath from a light that it is joined to.
#pragma once

#include "render/sensor/sensor.h"
#include "render/transport/bdpt/light_vertices.h"
#include "render/transport/vertex/dispersion.h"
#include "render/transport/vertex/light_choice.h"
#include "render/transport/vertex/light_end.h"
#include "render/transport/vertex/light_start.h"
#include "render/transport/vertex/path_state.h"

namespace tessera::render::TESSERA_ISA {

/// Sixteen vertices of subpaths from the eye.
struct EyeVertex {
  const Vertex& vertex;
  const PartialWeights& weights;  // once the subpaths have arrived
  Spectrum beta;
  int depth;      // events before
  Float merged;   // term of the sums from merging (LightSubpaths::merged_at)
  Int dispersed;  // PathFields::dispersed
  [[no_unique_address]] Spectra spectra;
};

/// Light that arrives where nothing is in the way.
struct WayLight {
  Spectrum unweighted;
  Float weight;
  WideConnection ray;  // ray whose contribution is left open
  Vec3 w;              // unit, to where the light comes from
  Mask shines;
};

/// Density, by solid angle, with which a path from the light that comes `from` there would go back along the
/// subpath from the eye.
TESSERA_INLINE Float back_density(const SceneTables& scene, const EyeVertex& z, Vec3 from, Mask active) {
  // From the first vertex a path from the light can only go on to the lens, which chance never finds.
  if (z.depth == 0) return Float(0.0f);
  return eval_scattering(scene, z.vertex, from, z.vertex.wo, active, Transport::kImportance).pdf;
}

/// The sums of a subpath from the eye as it arrives at `v`, `depth` events after its start, `before` being
/// where it was last scattered. Another subpath would find the same point of the lens, that of `u_lens`, so
/// many times where one from the eye does once.
TESSERA_INLINE PartialWeights arrive_at(const SceneTables& scene, const Vertex& v, int depth, Vec3 before,
                                        Vec2 u_lens, const Wavelengths& wavelengths, float subpaths,
                                        PartialWeights weights, Mask hit) {
  const Float cosine = cosine_at(v, v.wo);
  if (depth > 0) {
    weights.arrive(length_squared(v.surface.p - before) * UnitArea(scene.lights).inverse, cosine);
    return weights;
  }
  weights = {Float(0.0f), Float(0.0f)};
  if (!connects_to_points(scene.sensor)) return weights;
  const Float density = density_of_rays(scene.sensor, v.surface.p, -v.wo, u_lens, v.time, hit,
                                        first_wavelength(wavelengths, Float(kMiddleNm)));
  weights.last = power(subpaths / max(density * UnitArea(scene.lights).size * cosine, 1e-30f));
  return weights;
}

/// The weight of a subpath that, scattered last at `from`, has met `light` in this direction, at `point` with
/// unit normal `normal`, which has this cosine with the way back.
TESSERA_INLINE Float weight_of_hit(const SceneTables& scene, const PartialWeights& weights,
                                   const Receiver& from, Vec3 direction, Int light, Vec3 point, Vec3 normal,
                                   Float cosine, Float distance_squared, Mask lit) {
  const Float pdf = sampling_density(scene.lights, light, from, direction, point, normal, lit);
  return light_end(scene.lights, light, from.time, pdf, point, cosine, -direction, distance_squared, lit)
      .hit_weight(weights);
}
/// The same for a light at infinity.
TESSERA_INLINE Float weight_of_hit(const SceneTables& scene, const PartialWeights& weights,
                                   const Receiver& from, Vec3 direction, Int light, Mask lit) {
  return weight_of_hit(scene, weights, from, direction, light, from.p, direction, Float(1.0f), Float(1.0f),
                       lit);
}

/// Light of the one that was chosen, as sampled. With `weighs` false its weight is 1.
TESSERA_INLINE WayLight light_of(const SceneTables& scene, const EyeVertex& z, const LightChoice& choice,
                                 bool weighs) {
  WayLight way;
  way.shines = Mask::none();
  const Vertex& v = z.vertex;
  const LightSample& light = choice.sample;
  const Mask reachable = choice.pick.picked & light.valid;
  if (none(reachable)) return way;
  way.w = light.wi;
  const BsdfEval bsdf = eval_scattering(scene, v, light.wi, reachable);
  const Float pdf = light.pdf * choice.pick.pmf;
  way.unweighted = z.beta * bsdf.f_cos *
                   spectrum_of_light(scene, z.spectra, choice.pick.light, light.radiance, reachable) *
                   (1.0f / select(reachable, pdf, 1.0f));
  way.shines = and_not(reachable, is_black(way.unweighted));
  if (none(way.shines)) return way;

  const Vec3 point = fma(light.wi, light.distance, v.surface.p);
  way.weight = Float(1.0f);
  if (weighs) {
    const LightEnd end = light_end(scene.lights, choice.pick.light, v.time, pdf, point, light.cosine,
                                   -light.wi, sqr(light.distance), way.shines);
    way.weight = end.sampling_weight(z.weights, cosine_at(v, light.wi), bsdf.pdf,
                                     back_density(scene, z, light.wi, way.shines), z.merged);
  }
  way.ray = connect(scene, v, light.wi, point, way.shines);
  return way;
}

/// Light of the subpath from a light that has the vertices `y`, one of `paths` that all light is shared by.
TESSERA_INLINE WayLight light_of(const SceneTables& scene, const EyeVertex& z, const LightVertex& y,
                                 float paths, Float merged_at_y, bool weighs, Mask wanted) {
  WayLight way;
  const Vertex &v = z.vertex, &x = y.vertex;
  const Vec3 to_light = x.surface.p - v.surface.p;
  const Float distance_squared = length_squared(to_light);
  const Mask apart = wanted & (distance_squared > 0.0f);
  const Float inverse_square = 1.0f / select(apart, distance_squared, 1.0f);
  const Vec3 w = way.w = to_light * sqrt(inverse_square);
  const BsdfEval at_eye = eval_scattering(scene, v, w, apart);
  const BsdfEval at_light = eval_scattering(scene, x, -w, x.wo, apart);
  way.unweighted =
      z.beta * at_eye.f_cos * y.beta * at_light.f_cos * (adjoint_ratio(x, w) * inverse_square * paths);
  if (disperses(scene)) way.unweighted *= joined_factor(z.dispersed, y.dispersed);
  way.shines = and_not(apart & is_finite(way.unweighted), is_black(way.unweighted));
  if (none(way.shines)) return way;

  way.weight = Float(1.0f);
  if (weighs) {
    const Float forward = eval_scattering(scene, x, x.wo, -w, way.shines, Transport::kImportance).pdf;
    const Float by_area = inverse_square * UnitArea(scene.lights).size;
    const Float from_light =
        y.weights.ways(at_eye.pdf * cosine_at(x, w) * by_area, at_light.pdf, merged_at_y);
    const Float from_eye =
        z.weights.ways(forward * cosine_at(v, w) * by_area, back_density(scene, z, w, way.shines), z.merged);
    way.weight = weight_of_way(from_light, from_eye);
  }
  way.ray = connect(scene, v, w, select(x.in_medium, x.surface.p, offset_origin(x.surface, -w)), way.shines);
  return way;
}

/// Where subpaths from the eye go on.
struct EyeStep {
  WidePath next;
  PartialWeights weights;  // sums as the subpaths leave the vertex
  Mask specular, alive;    // nothing ends at random
};

TESSERA_INLINE EyeStep step_from_eye(const SceneTables& scene, const EyeVertex& z, const WidePath& path,
                                     Float u_lobe, Vec2 u, Mask hit) {
  const Vertex& v = z.vertex;
  const BsdfSample bsdf = sample_scattering(scene, v, u_lobe, u, hit);
  EyeStep step;
  WidePath& next = step.next;
  next = path;
  next.origin = next.reference = offset_origin(v.surface, bsdf.wi);
  next.direction = bsdf.wi;
  next.beta = path.beta * bsdf.weight;
  disperse_along(scene, v, bsdf, next);
  next.roulette_scale = select(bsdf.transmission, path.roulette_scale * sqr(bsdf.eta), path.roulette_scale);
  if (scene.lights.uses_normals) next.normal = receiver_at(scene, v).normal;
  if (scene.volumetric)
    next.medium = medium_behind(scene.shapes, v.surface, bsdf.wi, v.medium, and_not(hit, v.in_medium));
  step.specular = bsdf.specular;
  step.alive = and_not(hit & bsdf.valid, is_black(next.beta));
  const Float back = back_density(scene, z, bsdf.wi, and_not(step.alive, bsdf.specular));
  step.weights = z.weights.scattered(cosine_at(v, bsdf.wi), bsdf.pdf, back, z.merged, bsdf.specular);
  return step;
}

}  // namespace tessera::render::TESSERA_ISA
