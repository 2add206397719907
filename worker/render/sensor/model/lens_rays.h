// Rays through the surfaces of a lens, in either direction.
//
// A ray lies in a frame whose z points the way that it goes: to the scene, that of LensTable; to the film,
// its mirror image. So one code serves both.
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "render/sampling/piecewise2d_sample.h"
#include "render/sensor/lens_table.h"
#include "render/sensor/sensor.h"

namespace tessera::render::TESSERA_ISA {

/// A ray within the lens, in millimetres; direction of unit length.
struct LensRay {
  Vec3 origin, direction;
  Mask alive;
};

/// The way that rays go.
enum class LensWay { kToScene, kToFilm };
constexpr LensWay opposite(LensWay way) {
  return way == LensWay::kToScene ? LensWay::kToFilm : LensWay::kToScene;
}
constexpr float sign_of(LensWay way) { return way == LensWay::kToScene ? 1.0f : -1.0f; }

/// The same in the frame of the other way.
inline Vec3 mirrored(Vec3 v) { return {v.x, v.y, -v.z}; }

/// A conic and a polynomial over the squared height, and its slope by that.
struct LensSag {
  Float z, slope;
  Mask valid;
};
inline LensSag sag_at(const LensTable& lens, const LensSurfaceRecord& surface, LensWay way, Float h2) {
  const float c = surface.curvature * sign_of(way);
  const Float under = 1.0f - h2 * ((1 + surface.conic) * c * c);
  const Float root = sqrt(max(under, 1e-6f));
  LensSag sag{c * h2 / (1.0f + root), c * 0.5f / root, under > 0.0f};
  Float power = h2;
  for (std::int32_t i = 0; i < surface.coefficients; ++i) {
    const float a = lens.coefficients[static_cast<std::size_t>(surface.first_coefficient + i)] * sign_of(way);
    sag.slope = fma(power, a * static_cast<float>(i + 2), sag.slope);
    power = power * h2;
    sag.z = fma(power, a, sag.z);
  }
  return sag;
}

/// A vector but for its part along which a cylinder is straight; the whole of it at other surfaces.
inline Vec2 across(const LensSurfaceRecord& surface, Float x, Float y) {
  if (surface.shape != LensSurfaceShape::kCylinder) return {x, y};
  const Float along = x * surface.straight_x + y * surface.straight_y;
  return {x - along * surface.straight_x, y - along * surface.straight_y};
}

/// Moves the ray to the surface, and gives the unit normal there, on the side that the ray goes to.
inline Vec3 meet(const LensTable& lens, const LensSurfaceRecord& surface, LensWay way, LensRay& ray) {
  const float vertex = surface.z * sign_of(way);
  const Vec3 d = ray.direction;
  ray.alive &= d.z > 1e-4f;
  // Heights are counted from the vertex, so that they keep their digits.
  const Float to_vertex = (vertex - ray.origin.z) / max(d.z, 1e-4f);
  Vec3 p{fma(d.x, to_vertex, ray.origin.x), fma(d.y, to_vertex, ray.origin.y), Float(0.0f)};
  Vec3 normal{Float(0.0f), Float(0.0f), Float(1.0f)};
  if (surface.shape != LensSurfaceShape::kPlane) {
    const float c = surface.curvature * sign_of(way), k = 1 + surface.conic;
    const Vec2 da = across(surface, d.x, d.y), pa = across(surface, p.x, p.y);
    // The root next to the vertex [Welford 1986, section 4.3].
    const Float qa = c * (sqr(da.x) + sqr(da.y) + k * sqr(d.z)), qb = d.z - c * (pa.x * da.x + pa.y * da.y),
                qc = c * (sqr(pa.x) + sqr(pa.y));
    const Float under = qb * qb - qa * qc;
    ray.alive &= under >= 0.0f;
    const Float root = sqrt(max(under, 0.0f));
    Float t = qc / max(qb + root, 1e-6f);
    if (surface.shape == LensSurfaceShape::kSphere) {
      p = fma(d, t, p);
      normal = {p.x * -c, p.y * -c, 1.0f - c * p.z};
    } else {
      // Newton's steps, which conics do not need.
      const int steps = surface.coefficients > 0 ? 5 : 0;
      for (int i = 0;; ++i) {
        const Vec3 at = fma(d, t, p);
        const Vec2 ha = across(surface, at.x, at.y);
        const LensSag sag = sag_at(lens, surface, way, sqr(ha.x) + sqr(ha.y));
        normal = {ha.x * -2.0f * sag.slope, ha.y * -2.0f * sag.slope, Float(1.0f)};
        if (i == steps) {
          ray.alive &= sag.valid & (abs(at.z - sag.z) < 1e-3f);
          p = at;
          break;
        }
        const Float along = dot(normal, d);
        t = t - (at.z - sag.z) / select(abs(along) > 1e-6f, along, Float(1e-6f));
      }
      normal = normalize(normal);
    }
  }
  ray.origin = {p.x, p.y, p.z + vertex};
  const Float h2 = sqr(p.x) + sqr(p.y);
  ray.alive &= h2 <= surface.aperture_squared;
  for (std::int32_t i = 0; i < surface.edges; ++i) {
    const float* const edge = lens.edges.data() + surface.first_edge + 2 * i;
    ray.alive &= p.x * edge[0] + p.y * edge[1] <= surface.apothem;
  }
  return normal;
}

/// Ratios of indices at the wavelengths of 16 rays: a place between two of the table's.
struct WavelengthPlace {
  Int first = Int(0);
  Float part = Float(0.0f);
};
inline WavelengthPlace place_of(const LensTable& lens, Float nm) {
  if (lens.wavelengths == 1) return {};
  const Float place =
      clamp((nm - lens.first_nm) * lens.wavelengths_per_nm, 0.0f, static_cast<float>(lens.wavelengths - 1));
  const Int first = min(to_int(place), lens.wavelengths - 2);
  return {first, place - to_float(first)};
}
/// The value of `table` for a surface; it has all of the lens's wavelengths for each of them.
inline Float at_wavelength(const std::vector<float>& table, const LensTable& lens, std::size_t surface,
                           const WavelengthPlace& place) {
  const float* const values = table.data() + surface * static_cast<std::size_t>(lens.wavelengths);
  if (lens.wavelengths == 1) return Float(values[0]);
  const Float low = gather(values, place.first, Mask::all()),
              high = gather(values + 1, place.first, Mask::all());
  return fma(place.part, high - low, low);
}

/// Snell's law; the normal is on the side that the ray goes to.
inline void refract(Vec3 normal, Float ratio, LensRay& ray) {
  const Float cosine = dot(normal, ray.direction);
  const Float squared = 1.0f - sqr(ratio) * (1.0f - sqr(cosine));
  ray.alive &= (squared > 0.0f) & (cosine > 0.0f);
  ray.direction = normalize(ray.direction * ratio + normal * (sqrt(max(squared, 0.0f)) - ratio * cosine));
}

/// Transmission of the aperture's picture at a place of it, in radii.
inline Float transmission_at(const AperturePicture& picture, Vec2 place) {
  const Mask within = (abs(place.x) <= 1.0f) & (abs(place.y) <= 1.0f);
  const Vec2 uv{fma(place.x, Float(0.5f), Float(0.5f)), fma(place.y, Float(0.5f), Float(0.5f))};
  return select_or_zero(within, piecewise2d_density(picture.density, uv, within) * picture.transmission);
}

/// Transmission of the stop where the ray has met it.
inline Float stop_transmission(const LensTable& lens, const LensSurfaceRecord& stop, const LensRay& ray) {
  const float per_radius = 1 / std::sqrt(stop.aperture_squared);
  return transmission_at(lens.picture, {ray.origin.x * per_radius, ray.origin.y * per_radius});
}

}  // namespace tessera::render::TESSERA_ISA
