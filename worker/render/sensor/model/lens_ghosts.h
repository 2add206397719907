// Rays that surfaces of a lens reflect and dim [Hullin et al. 2011]: by Fresnel's equations and coatings of
// one layer, unpolarised (optics::reflectance() in doubles).
#pragma once

#include "render/core/constants.h"
#include "render/sampling/warp.h"
#include "render/sensor/model/flat_raster.h"
#include "render/sensor/model/lens_rays.h"

namespace tessera::render::TESSERA_ISA {

/// The part of a ray's light that is left: of red, green and blue, or of one wavelength in all three.
struct LensLight {
  Vec3 part{Float(1.0f), Float(1.0f), Float(1.0f)};
};

/// A ray's light, as surfaces see it.
struct LensColours {
  WavelengthPlace place;
  bool one = false;  // they are one wavelength
  // Nanometres; those of red, green and blue are the dominant wavelengths of Rec.709's primaries.
  Vec3 nm{Float(611.4f), Float(549.1f), Float(464.2f)};
};
inline LensColours colours_of(const SensorRecord& sensor, Float nm) {
  LensColours colours{.place = place_of(*sensor.lens, nm), .one = sensor.disperses};
  if (colours.one) colours.nm = {nm, nm, nm};
  return colours;
}

/// Where light goes from one index to another.
struct LensBoundary {
  Float from, to;                // indices
  Float cosine_from, cosine_to;  // to the normal on both sides
  Mask total;                    // it is totally reflected
};
inline LensBoundary boundary_at(const LensTable& lens, std::size_t surface, LensWay way,
                                const WavelengthPlace& place, Float cosine) {
  const Float film_side = at_wavelength(lens.ghosts.indices, lens, surface, place),
              scene_side = at_wavelength(lens.ghosts.indices, lens, surface + 1, place);
  LensBoundary boundary;
  boundary.from = way == LensWay::kToScene ? film_side : scene_side;
  boundary.to = way == LensWay::kToScene ? scene_side : film_side;
  boundary.cosine_from = min(abs(cosine), 1.0f);
  const Float squared = fnma(sqr(boundary.from / boundary.to), 1.0f - sqr(boundary.cosine_from), Float(1.0f));
  boundary.total = squared <= 0.0f;
  boundary.cosine_to = safe_sqrt(squared);
  return boundary;
}

/// Part of unpolarised light that the boundary reflects, through a layer where the surface has one.
inline Float reflectance(const LensBoundary& b, const LensSurfaceRecord& surface, Float nm) {
  const auto s_of = [](Float n, Float c, Float n_next, Float c_next) {
    return (n * c - n_next * c_next) / max(n * c + n_next * c_next, 1e-12f);
  };
  const auto p_of = [](Float n, Float c, Float n_next, Float c_next) {
    return (n_next * c - n * c_next) / max(n_next * c + n * c_next, 1e-12f);
  };
  Float sum;
  if (surface.coating_index > 0) {
    constexpr float kLeastCosine = 1e-3f;
    const Float n(surface.coating_index);
    const Float squared = fnma(sqr(b.from / n), 1.0f - sqr(b.cosine_from), Float(1.0f));
    const Float c = max(safe_sqrt(squared), kLeastCosine);
    const Float turn = cos(c * (4 * kPi * surface.coating_index * surface.coating_nm) / nm);
    const auto of_layer = [&](Float first, Float second) {
      const Float both = first * second, interference = 2.0f * both * turn;
      return (sqr(first) + sqr(second) + interference) / (1.0f + sqr(both) + interference);
    };
    sum = of_layer(s_of(b.from, b.cosine_from, n, c), s_of(n, c, b.to, b.cosine_to)) +
          of_layer(p_of(b.from, b.cosine_from, n, c), p_of(n, c, b.to, b.cosine_to));
  } else {
    sum = sqr(s_of(b.from, b.cosine_from, b.to, b.cosine_to)) +
          sqr(p_of(b.from, b.cosine_from, b.to, b.cosine_to));
  }
  return select(b.total, 1.0f, sum * 0.5f);
}

/// Moves the rays of the lanes `on`, which are alive, to a surface that reflects some of them and refracts
/// the others. Those reflected are then in the frame of the other way.
inline void meet_and_dim(const LensTable& lens, std::size_t number, LensWay way, const LensColours& colours,
                         Mask on, Mask reflected, LensRay& ray, LensLight& light) {
  const LensSurfaceRecord& surface = lens.surfaces[number];
  LensRay there = ray;
  const Vec3 normal = meet(lens, surface, way, there);
  Vec3 part{Float(1.0f), Float(1.0f), Float(1.0f)};
  if (surface.refracts != 0) {
    const LensBoundary boundary = boundary_at(lens, number, way, colours.place, dot(normal, there.direction));
    const auto part_of = [&](Float nm) {
      const Float back = reflectance(boundary, surface, nm);
      return select(reflected, back, 1.0f - back);
    };
    part.x = part_of(colours.nm.x);
    const bool grey = colours.one || surface.coating_index == 0;
    part.y = grey ? part.x : part_of(colours.nm.y);
    part.z = grey ? part.x : part_of(colours.nm.z);
    LensRay refracted = there;
    refract(normal, boundary.from / boundary.to, refracted);
    const Vec3 back = there.direction - normal * (2.0f * dot(normal, there.direction));
    there.direction = select(reflected, mirrored(back), refracted.direction);
    there.origin = select(reflected, mirrored(there.origin), there.origin);
    there.alive &= reflected | refracted.alive;
  }
  if (surface.is_stop != 0 && lens.picture.any()) {
    const Float open = stop_transmission(lens, surface, there);
    part = part * open;
  }
  ray.origin = select(on, there.origin, ray.origin);
  ray.direction = select(on, there.direction, ray.direction);
  ray.alive = (on & there.alive) | and_not(ray.alive, on);
  light.part =
      select(on, Vec3{light.part.x * part.x, light.part.y * part.y, light.part.z * part.z}, light.part);
}

/// Follows rays through all surfaces, once they were reflected twice: those that come to the film by the
/// bounce `near_film`, `near_scene`, or the same backwards.
inline void follow_bounce(const LensTable& lens, LensWay way, const LensColours& colours, Int near_film,
                          Int near_scene, LensRay& ray, LensLight& light) {
  const auto n = static_cast<std::int32_t>(lens.surfaces.size());
  // Surfaces in the order in which rays come to them.
  const bool to_scene = way == LensWay::kToScene;
  const Int first = to_scene ? near_scene : (n - 1) - near_film,
            second = to_scene ? near_film : (n - 1) - near_scene;
  const auto pass = [&](std::int32_t at, LensWay going, Mask lanes, Mask reflected) {
    const Mask on = ray.alive & lanes;
    if (none(on)) return;
    meet_and_dim(lens, static_cast<std::size_t>(to_scene ? at : n - 1 - at), going, colours, on, reflected,
                 ray, light);
  };
  for (std::int32_t at = 0; at < n; ++at) pass(at, way, first >= at, first == at);
  for (std::int32_t at = n - 1; at-- > 0;)
    pass(at, opposite(way), (first > at) & (second <= at), second == at);
  for (std::int32_t at = 1; at < n; ++at) pass(at, way, second < at, Mask::none());
}

/// Points of the outermost surface on one side, evenly spread over the plane of its vertex.
struct LensOpening {
  Vec3 point, normal;  // frame of LensTable; the normal points to the scene, of unit length
};
inline Vec3 normal_on(const LensTable& lens, const LensSurfaceRecord& surface, Vec2 at) {
  const Vec2 h = across(surface, at.x, at.y);
  const Float slope = sag_at(lens, surface, LensWay::kToScene, sqr(h.x) + sqr(h.y)).slope;
  return normalize(Vec3{h.x * -2.0f * slope, h.y * -2.0f * slope, Float(1.0f)});
}
inline LensOpening sample_opening(const LensTable& lens, const LensSurfaceRecord& surface, Vec2 u) {
  const Vec2 disk = square_to_disk(u);
  const float radius = std::sqrt(surface.aperture_squared);
  const Vec2 at{disk.x * radius, disk.y * radius}, h = across(surface, at.x, at.y);
  const Float sag = sag_at(lens, surface, LensWay::kToScene, sqr(h.x) + sqr(h.y)).z;
  return {{at.x, at.y, sag + surface.z}, normal_on(lens, surface, at)};
}

/// The area across the ray that a point of sample_opening() stands for: mm^2.
inline Float opening_across(const LensSurfaceRecord& surface, Vec3 normal, Vec3 direction) {
  return abs(dot(normal, direction)) / normal.z * (kPi * surface.aperture_squared);
}

/// The etendue that a ray from the film stands for, before the lens is looked at: mm^2 sr for each mm^2 of
/// the film. `at`: where it meets the surface next to the film.
inline Float film_etendue(const LensTable& lens, Vec3 film, Vec3 at) {
  const LensSurfaceRecord& surface = lens.surfaces.front();
  const Vec3 way = at - film;
  const Float squared = length_squared(way);
  const Vec3 direction = way * (1.0f / sqrt(squared));
  return opening_across(surface, normal_on(lens, surface, {at.x, at.y}), direction) * abs(direction.z) /
         squared;
}

/// SensorRay::pdf of a ray that leaves the lens at `point` along `direction`: rays from the film against
/// those that lights send in, whose densities have all factors but these in common. `etendue`:
/// film_etendue().
inline Float rival_density(const SensorRecord& sensor, Vec3 point, Vec3 direction, Float etendue) {
  const LensTable& lens = *sensor.lens;
  const LensSurfaceRecord& front = lens.surfaces.back();
  const float pixel = pixel_area(sensor) * lens.film_distance * lens.film_distance;
  const Float across = opening_across(front, normal_on(lens, front, {point.x, point.y}), direction);
  return across / etendue * (lens.ghosts.part / (pixel * lens.ghosts.rays_of_lights));
}

}  // namespace tessera::render::TESSERA_ISA
