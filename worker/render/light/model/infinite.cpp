#include "render/core/affine.h"
#include "render/light/emission.h"
#include "render/light/light.h"
#include "render/light/light_access.h"
#include "render/sampling/piecewise2d_sample.h"
#include "render/sampling/sphere_map.h"
#include "render/sampling/warp.h"

namespace tessera::render::TESSERA_ISA {
namespace {

const Environment& environment_of(const LightTable& table, std::int32_t light) {
  return table
      .environments[static_cast<std::size_t>(table.lights[static_cast<std::size_t>(light)].environment)];
}

struct Texel {
  Color radiance;
  Float density;  // the distribution's in this cell
};

Texel whole_texel(const Environment& e, Int x, Int y, Mask active) {
  const Float4 rgbd = gather4(e.texels.data(), (y * e.width + x) * 4, active);
  Texel result;
  result.radiance = color_of([&](int band) { return select_or_zero(active, rgbd.c[band]); });
  result.density = select_or_zero(active, rgbd.c[kBands]);
  return result;
}

Color texel(const Environment& e, Int x, Int y, Mask active) { return whole_texel(e, x, y, active).radiance; }

/// pbrt-v4 reads its octahedral maps without interpolation.
Color nearest(const Environment& e, Vec2 uv, Mask active) {
  return texel(e, clamp(to_int(uv.x * static_cast<float>(e.width)), 0, e.width - 1),
               clamp(to_int(uv.y * static_cast<float>(e.height)), 0, e.height - 1), active);
}

/// Round about in u, up to the poles in v.
Color bilinear(const Environment& e, Vec2 uv, Mask active) {
  // Mitsuba 3's grid: columns have their centres at half-integers, but the first and last rows lie on the
  // poles.
  const Float x = uv.x * static_cast<float>(e.width) - 0.5f, y = uv.y * static_cast<float>(e.height - 1);
  const Float x_floor = floor(x), y_floor = floor(y);
  const Int left = to_int(x_floor), top = to_int(y_floor);
  const Int x0 = select(left < 0, left + e.width, left), x1 = select(left + 1 >= e.width, Int(0), left + 1);
  const Int y0 = max(top, 0), y1 = min(top + 1, e.height - 1);
  const Float tx = x - x_floor, ty = y - y_floor;
  return lerp(ty, lerp(tx, texel(e, x0, y0, active), texel(e, x1, y0, active)),
              lerp(tx, texel(e, x0, y1, active), texel(e, x1, y1, active)));
}

Color uniform_radiance(const LightRecord& record, Mask active) {
  return select_or_zero(active, color_of(record.radiance));
}

/// The parallelogram through which the light comes, to the side of its normal only [pbrt-v4
/// PortalImageInfiniteLight].
struct PortalPlane {
  Vec3 corner, side_u, side_v, normal;
  Float area;

  explicit PortalPlane(const Environment& e)
      : corner{Float(e.portal[0]), Float(e.portal[1]), Float(e.portal[2])},
        side_u{Float(e.portal[3]), Float(e.portal[4]), Float(e.portal[5])},
        side_v{Float(e.portal[6]), Float(e.portal[7]), Float(e.portal[8])},
        normal(normalize(cross(side_u, side_v))),
        area(e.portal_area) {}
};

/// Solid-angle density of a direction towards a uniformly chosen point at this distance; zero from behind.
Float portal_pdf(const PortalPlane& plane, Float distance_squared, Vec3 wi) {
  const Float cosine = -dot(plane.normal, wi);
  return select_or_zero(cosine > 0.0f, distance_squared / max(plane.area * cosine, 1e-30f));
}

/// Whether light along `wi` comes to `origin` through the portal; all of it where there is none.
Mask through_portal(const Environment& e, Vec3 origin, Vec3 wi, Mask active) {
  if (e.portal_area == 0) return active;
  const PortalPlane plane(e);
  const Float slope = dot(wi, plane.normal);
  const Float t = dot(plane.corner - origin, plane.normal) / select(slope == 0.0f, 1.0f, slope);
  const Vec3 at = fma(wi, t, origin - plane.corner);
  // Coordinates along the sides of a parallelogram.
  const Float a = dot(cross(at, plane.side_v), plane.normal), b = dot(cross(plane.side_u, at), plane.normal);
  return active & (slope < 0.0f) & (t > 0.0f) & (a >= 0.0f) & (a <= plane.area) & (b >= 0.0f) &
         (b <= plane.area);
}

Color map_radiance(const Environment& e, const LightRecord& record, Vec3 wi, Mask active) {
  if (e.mapping == EnvironmentMapping::kUniform) return uniform_radiance(record, active);
  const Vec3 w = normalize(transform_vector(e.light_from_render, wi));
  if (e.mapping == EnvironmentMapping::kEqualAreaOctahedral)
    return nearest(e, octahedral_from_direction(w), active);
  return bilinear(e, latlong_from_direction(w).uv, active);
}

/// A direction in light space with what is known of it.
struct MapSample {
  Vec3 w;
  Color radiance;
  Float pdf;
};

MapSample sample_map(const Environment& e, const LightRecord& record, Vec2 u, Mask active) {
  if (e.mapping == EnvironmentMapping::kUniform) {
    return {square_to_sphere(u), uniform_radiance(record, active), Float(kInv4Pi)};
  }
  const Piecewise2dPlace place = locate_piecewise2d(e.distribution, u, active);
  const Texel cell = whole_texel(e, place.x, place.y, active);
  if (e.mapping == EnvironmentMapping::kEqualAreaOctahedral) {
    return {direction_from_octahedral(place.uv), cell.radiance, cell.density * kInv4Pi};
  }
  const Vec3 w = direction_from_latlong(place.uv);
  const Float sin_theta = sin(kPi * place.uv.y);
  return {w, bilinear(e, place.uv, active), cell.density * (kInv2Pi * kInvPi) / max(sin_theta, 1e-12f)};
}

Float map_pdf(const Environment& e, Vec3 w, Mask active) {
  switch (e.mapping) {
    case EnvironmentMapping::kUniform:
      break;
    case EnvironmentMapping::kEqualAreaOctahedral:
      return piecewise2d_density(e.distribution, octahedral_from_direction(w), active) * kInv4Pi;
    case EnvironmentMapping::kLatitudeLongitude: {
      const LatLong place = latlong_from_direction(w);
      return piecewise2d_density(e.distribution, place.uv, active) * (kInv2Pi * kInvPi) /
             max(place.sin_theta, 1e-12f);
    }
  }
  return select_or_zero(active, Float(kInv4Pi));
}

/// A point of the portal, uniformly; the environment is looked up behind it.
LightSample sample_portal(const Environment& e, const LightRecord& record, Vec3 reference, Vec2 u,
                          Mask active) {
  const PortalPlane plane(e);
  const Vec3 to = fma(plane.side_v, u.y, fma(plane.side_u, u.x, plane.corner - reference));
  const Float distance_squared = length_squared(to);
  LightSample s;
  s.wi = normalize(to);
  s.distance = Float(kInfiniteDistance);
  s.radiance = map_radiance(e, record, s.wi, active);
  s.pdf = portal_pdf(plane, distance_squared, s.wi);
  s.valid = active & (s.pdf > 0.0f) & is_finite(s.pdf);
  s.delta = Mask::none();
  return s;
}

/// Light from all directions, sampled in proportion to the radiance of an environment map.
class InfiniteLight final : public LightModel {
 public:
  InfiniteLight() : LightModel({.at_infinity = true}) {}

  LightSample sample(const LightTable& table, Int light, const Receiver& from, Vec2 u,
                     Mask active) const override {
    LightSample result{{0.0f, 0.0f, 1.0f}, Float(kInfiniteDistance), Color(0.0f), Float(0.0f), Mask::none(),
                       Mask::none()};
    for_each_distinct(light, active, [&](std::int32_t i, Mask lanes) {
      const Environment& e = environment_of(table, i);
      if (e.portal_area > 0) {
        result = select(lanes, sample_portal(e, table.lights[static_cast<std::size_t>(i)], from.p, u, lanes),
                        result);
        return;
      }
      const MapSample s = sample_map(e, table.lights[static_cast<std::size_t>(i)], u, lanes);
      result.wi = select(lanes, normalize(transform_vector(e.render_from_light, s.w)), result.wi);
      result.radiance = select(lanes, s.radiance, result.radiance);
      result.pdf = select(lanes, s.pdf, result.pdf);
      result.valid |= lanes & (s.pdf > 0.0f);
    });
    return result;
  }

  Float pdf(const LightTable& table, Int light, const Receiver& from, Vec3 wi, Vec3, Vec3,
            Mask active) const override {
    Float result(0.0f);
    for_each_distinct(light, active, [&](std::int32_t i, Mask lanes) {
      const Environment& e = environment_of(table, i);
      if (e.portal_area > 0) {
        const PortalPlane plane(e);
        const Float slope = dot(wi, plane.normal);
        const Float t = dot(plane.corner - from.p, plane.normal) / select(slope == 0.0f, 1.0f, slope);
        const Mask open = through_portal(e, from.p, wi, lanes);
        result = select(lanes, select_or_zero(open, portal_pdf(plane, sqr(t), wi)), result);
        return;
      }
      result = select(lanes, map_pdf(e, normalize(transform_vector(e.light_from_render, wi)), lanes), result);
    });
    return result;
  }

  Emission emit(const LightTable& table, Int light, Float time, Vec2 u_place, Vec2 u_direction,
                Mask active) const override {
    return emit_from_infinity(*this, table, light, time, u_place, u_direction, active);
  }
  EmissionDensity emission_density(const LightTable& table, Int light, Float, Vec3 point, Float,
                                   Vec3 direction, Mask active) const override {
    return {Float(kInvPi / (table.scene_radius * table.scene_radius)),
            pdf(table, light, point, -direction, point, direction, active)};
  }

  double power(const LightTable& table, const LightRecord& light) const override {
    const Environment& e = table.environments[static_cast<std::size_t>(light.environment)];
    const bool even = e.mapping == EnvironmentMapping::kUniform;
    return scene_disk(table) * (even ? 4 * std::numbers::pi * mean_radiance(light) : e.flux);
  }
  LightBounds bounds(const LightTable&, const LightRecord&) const override { return {}; }
};

}  // namespace

const ModelOf<InfiniteLight> infinite(LightKind::kInfinite);

Color still_environment_radiance(const LightTable& table, int light, const Receiver& from, Vec3 wi,
                                 Mask active) {
  const Environment& e = environment_of(table, light);
  return map_radiance(e, table.lights[static_cast<std::size_t>(light)], wi,
                      through_portal(e, from.p, wi, active));
}

}  // namespace tessera::render::TESSERA_ISA
