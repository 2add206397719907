#include "render/integrator/mlt/path_space/measure.h"

#include <algorithm>

#include "render/camera/camera.h"
#include "render/film/summable.h"
#include "render/integrator/mlt/path_space/delta_lobe.h"
#include "render/integrator/vertex/light_end.h"
#include "render/integrator/vertex/vertex.h"

namespace tessera::render::TESSERA_ISA {

FilmPlane::FilmPlane(const SceneTables& scene)
    // Filters are about the pixels' centres.
    : left(0.5f - scene.filter.x.radius),
      top(0.5f - scene.filter.y.radius),
      width(static_cast<float>(scene.camera.width) - 2 * left),
      height(static_cast<float>(scene.camera.height) - 2 * top) {}

/// A vertex of sixteen paths as the eye sees it, and as its light does.
struct PathMeasure::Vertices {
  Vertex from_eye;
  Interaction from_light;
};

/// Densities are by solid angle; of delta lobes factors, as ExplicitPath has them.
struct PathMeasure::Scattering {
  Spectrum f_cos;
  Float to_light, to_eye;
  Float light_choice;  // to_eye, or the probability of a delta lobe
  Mask transmits;
  Mask known;  // how light gets there
};

/// An end on a light and the edge to it; by area or solid angle as for ExplicitPath.
struct PathMeasure::End {
  Spectrum light;  // with all of the edge's geometry but what f_cos has
  Float sampled, emitted, hit, slope;
};

PathMeasure::Scattering PathMeasure::scattering_at(const Vertices& v, Vec3 wi, Mask specular,
                                                   Mask lanes) const {
  const Vec3 wo = v.from_eye.wo;
  const Mask spread = and_not(lanes, specular);
  Scattering s{Spectrum(0.0f), Float(0.0f), Float(0.0f), Float(0.0f), Mask::none(), lanes};
  if (any(spread)) {
    const BsdfEval bsdf = eval_bsdf(v.from_eye.at, wo, wi, spread);
    s.f_cos = bsdf.f_cos;
    s.to_light = bsdf.pdf;
    s.to_eye = s.light_choice = eval_bsdf(v.from_light, wi, wo, spread, Transport::kImportance).pdf;
  }
  if (const Mask delta = lanes & specular; any(delta)) {
    const DeltaLobe there = find_delta_lobe(v.from_eye.at, wo, Transport::kRadiance, delta, leads_along(wi));
    const DeltaLobe back = find_delta_lobe(v.from_light, wi, Transport::kImportance, delta, leads_along(wo));
    s.known = and_not(s.known, and_not(delta, there.found & back.found));
    s.f_cos = select(delta, there.weight * there.probability, s.f_cos);
    s.to_light = select(delta, there.probability, s.to_light);
    s.light_choice = select(delta, back.probability, s.light_choice);
    // Refraction narrows pencils of rays: projected solid angle times the squared index stays.
    const Vec3 n = v.from_eye.at.frame.z;
    const Float narrowing = abs(dot(wo, n)) / (max(abs(dot(wi, n)), 1e-9f) * sqr(there.eta));
    s.to_eye = select(delta, back.probability * narrowing, s.to_eye);
    s.transmits = delta & there.transmission;
  }
  return s;
}

Spectrum PathMeasure::radiance_of(const WidePoint& end, Vec3 from, Vec3 wi, Mask lanes) const {
  Spectrum light(0.0f);
  const Mask on_surface = lanes & (end.place == kOnSurface);
  if (any(on_surface)) {
    light = select_or_zero(on_surface,
                           emitted_radiance(scene_.lights, end.light, surface_of(end), -wi, on_surface));
  }
  const Mask delta = delta_lights(scene_.lights, end.light, lanes);
  if (any(delta)) {
    const LightSample sample =
        sample_light(scene_.lights, end.light, from, {Float(0.5f), Float(0.5f)}, delta);
    light = select(delta, select_or_zero(sample.valid, sample.radiance), light);
  }
  const Mask around = and_not(lanes & (end.place == kAtInfinity), delta);
  for_each_distinct(end.light, around, [&](std::int32_t number, Mask same) {
    light = select(same, environment_radiance(scene_.lights, number, from, wi, same), light);
  });
  return light;
}

PathMeasure::End PathMeasure::end_at(const Vertices& v, const WidePoint& end, Vec3 wi, Mask lanes) const {
  const Vertex& vertex = v.from_eye;
  const Vec3 here = vertex.surface.p;
  const Mask at_infinity = end.place == kAtInfinity, on_surface = end.place == kOnSurface;
  const Vec3 point = select(at_infinity, here, end.p), normal = select(at_infinity, wi, end.ng);
  const Float cosine = select(on_surface, dot(end.ng, -wi), 1.0f);
  const Float distance2 = select(at_infinity, 1.0f, length_squared(end.p - here));
  const Float pdf =
      sampling_density(scene_.lights, end.light, receiver_at(scene_, vertex), wi, point, normal, lanes);
  const LightEnd ways = light_end(scene_.lights, end.light, pdf, point, cosine, -wi, distance2, lanes);
  const Float inverse_square = 1.0f / max(distance2, 1e-30f);
  End result;
  result.slope = cosine_at(vertex, wi) * inverse_square;
  result.sampled = ways.sampled * inverse_square;
  result.emitted = ways.emitted * UnitArea(scene_.lights).inverse * result.slope;
  result.hit = ways.hit * inverse_square;
  // Intensity has been divided by the squared distance.
  result.light =
      radiance_of(end, here, wi, lanes) * select(on_surface, abs(cosine) * inverse_square, Float(1.0f));
  return result;
}

void PathMeasure::measure(ExplicitPath* const (&paths)[kWidth], Mask wanted) const {
  const auto points = [&](int vertex) {
    return load_points(
        [&](int i) -> const PathPoint& { return paths[i]->points[std::min(vertex, paths[i]->events + 1)]; });
  };
  const auto write = [&](Mask lanes, Float values, auto&& to) {
    for (std::uint32_t bits = lanes.bits(); bits != 0; bits &= bits - 1) {
      const int i = __builtin_ctz(bits);
      to(*paths[i]) = values.lane(i);
    }
  };
  const Int events = ints_of([&](int i) { return paths[i]->events; });
  const Float time = floats_of([&](int i) { return paths[i]->time; });
  const Vec2 lens{floats_of([&](int i) { return paths[i]->lens_x; }),
                  floats_of([&](int i) { return paths[i]->lens_y; })};
  WidePoint here = points(1);
  const CameraConnection eye = connect_to_camera(scene_.camera, here.p, lens, time, wanted);
  Mask valid = wanted & eye.valid & (eye.film.x >= film_.left) & (eye.film.y >= film_.top) &
               (eye.film.x < film_.left + film_.width) & (eye.film.y < film_.top + film_.height);
  Spectrum light(scene_.exposure);
  // Products of inverse squares leave the range of floats.
  double geometries[kWidth];
  std::fill_n(geometries, kWidth, 1.0);
  Float density = eye.importance * (1.0f / film_.area()), geometry = eye.importance;
  Float cosine_before(1.0f), distance2_before(1.0f);
  Vec3 before = eye.lens;
  for (int i = 1; any(valid & (events >= i)); ++i) {
    const Mask lanes = valid & (events >= i), last = lanes & (events == i);
    const WidePoint next = points(i + 1);
    const Vec3 to_next = next.p - here.p;
    const Float distance2 = length_squared(to_next);
    const Vec3 wi =
        select(last & (next.place == kAtInfinity), next.p, to_next * (1.0f / sqrt(max(distance2, 1e-30f))));
    Vertices v;
    v.from_eye.wo = normalize(before - here.p);
    v.from_eye.time = time;
    v.from_eye.surface = surface_of(here);
    interact(scene_, v.from_eye.surface, v.from_eye.wo, here.mix, lanes, v.from_eye.at);
    v.from_light = v.from_eye.at;
    // Materials may be others from behind.
    if (scene_.any_mix || scene_.any_tangents)
      interact(scene_, v.from_eye.surface, wi, here.mix, lanes, v.from_light);
    const Scattering s = scattering_at(v, wi, here.specular != 0, lanes);
    valid = and_not(valid, and_not(lanes, s.known));

    const Float cosine = cosine_at(v.from_eye, v.from_eye.wo);
    write(lanes, density * cosine, [&](ExplicitPath& path) -> float& { return path.from_eye[i]; });
    light = select(lanes, light * s.f_cos, light);
    const Float slope = geometry * cosine;
    for (std::uint32_t bits = lanes.bits(); bits != 0; bits &= bits - 1) {
      const int k = __builtin_ctz(bits);
      geometries[k] *= double{slope.lane(k)};
      paths[k]->transmits[i] = (s.transmits.bits() >> k & 1) != 0;
    }
    if (i > 1) {
      write(lanes, s.to_eye * cosine_before / distance2_before,
            [&](ExplicitPath& path) -> float& { return path.from_light[i - 1]; });
    }
    write(lanes, s.to_light, [&](ExplicitPath& path) -> float& { return path.eye_choice[i]; });
    write(lanes, s.light_choice, [&](ExplicitPath& path) -> float& { return path.light_choice[i]; });
    if (any(last)) {
      const End end = end_at(v, next, wi, last);
      light = select(last, light * end.light, light);
      write(last, s.to_light * end.hit, [&](ExplicitPath& path) -> float& { return path.from_eye[i + 1]; });
      write(last, end.sampled, [](ExplicitPath& path) -> float& { return path.sampled; });
      write(last, end.emitted, [](ExplicitPath& path) -> float& { return path.emitted; });
      write(last, end.slope, [](ExplicitPath& path) -> float& { return path.end_slope; });
    }
    before = here.p;
    here = next;
    cosine_before = cosine_at(v.from_eye, wi);
    distance2_before = max(distance2, 1e-30f);
    geometry = 1.0f / distance2_before;
    density = s.to_light * geometry;
  }
  for (int c = 0; c < kSpectrumLanes; ++c) valid &= is_summable(light.c[c]);
  const Float bright = select_or_zero(valid, max(luminance(light), 0.0f));
  for (std::uint32_t bits = wanted.bits(); bits != 0; bits &= bits - 1) {
    const int i = __builtin_ctz(bits);
    ExplicitPath& path = *paths[i];
    path.film_x = eye.film.x.lane(i), path.film_y = eye.film.y.lane(i);
    path.luminance = bright.lane(i);
    path.brightness = double{path.luminance} * geometries[i];
    for (int c = 0; c < kSpectrumLanes; ++c) path.light[c] = light.c[c].lane(i);
  }
}

}  // namespace tessera::render::TESSERA_ISA
