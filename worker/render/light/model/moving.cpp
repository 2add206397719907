// Lights that move, as lights that stand still in a space of their own: a receiver is taken to that space as
// it is placed at the receiver's time, and what is found there is brought back. Maps may stretch: solid
// angles grow by |det M| / |M w|^3 along a unit vector w, and areas times cosines times solid angles
// (etendue) by det(M)^2 / |M w|^4.
#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "render/core/motion.h"
#include "render/light/emission.h"
#include "render/light/light.h"
#include "render/light/light_access.h"
#include "render/light/light_cone.h"
#include "render/light/moving_lights.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// The maps of 16 lights at their times.
struct MovedSpace {
  WideAffine to, from;  // light space to render space, and back
  Float determinant;    // size of that of `to`
  Float shift;          // as MovedAffine has it
  Int instance;

  MovedSpace(const MovingLights& moving, Int light, Float time, Mask active) {
    const Int motion = gather(moving.motion_of_light.data(), light, active);
    const auto field = [&](std::int32_t LightMotion::*member) {
      return gather_member(moving.motions.data(), member, motion, active);
    };
    const MovedAffine at = affine_at(moving.steps.data(), field(&LightMotion::first_step),
                                     select(active, field(&LightMotion::segments), Int(1)), time, active);
    // Lanes that nobody asks for get the identity: nothing is divided by zero.
    for (int i = 0; i < 12; ++i) to.m[i] = select(active, at.map.m[i], i % 5 == 0 ? 1.0f : 0.0f);
    from = inverse(to);
    const auto& m = to.m;
    determinant = abs(dot(Vec3{m[0], m[1], m[2]}, cross({m[4], m[5], m[6]}, {m[8], m[9], m[10]})));
    shift = at.shift;
    instance = field(&LightMotion::instance);
  }

  TESSERA_INLINE Receiver receiver(const Receiver& from_render) const {
    Receiver result(transform_point(from, from_render.p));
    const Vec3 n = transform_normal(to, from_render.normal);
    const Float l2 = length_squared(n);
    const Float scale = select_or_zero(l2 > 0.0f, 1.0f / sqrt(select(l2 > 0.0f, l2, 1.0f)));
    result.normal = n * scale;
    result.roughly = from_render.roughly;
    result.time = from_render.time;
    return result;
  }
  /// Factor by which solid angles about `w` in light space, a unit vector that is as long as `stretch` in
  /// render space, are larger there.
  TESSERA_INLINE Float solid_angle(Float stretch) const {
    return determinant / (stretch * stretch * stretch);
  }
  TESSERA_INLINE Float etendue(Float stretch) const { return sqr(determinant) / sqr(sqr(stretch)); }
  /// How many times larger a rounding becomes on the way to light space and back.
  TESSERA_INLINE Float condition() const { return norm(to) * norm(from) * (1.0f / 3.0f); }
  TESSERA_INLINE Float error(Vec3 reference, Vec3 point, Float distance) const {
    return ray_end_error(reference, point, shift, distance) * condition();
  }

 private:
  static Float norm(const WideAffine& a) {
    Float sum(0.0f);
    for (int i = 0; i < 12; ++i)
      if (i % 4 != 3) sum = fma(a.m[i], a.m[i], sum);
    return sqrt(sum);
  }
};

/// The kind that a light is but for its motion, and how that one stands in its own space.
const LightRecord& still_record(const LightTable& table, const LightRecord& light) {
  return table.moving->still.lights[static_cast<std::size_t>(light.profile)];
}

std::span<const Affine> steps_of(const LightTable& table, const LightRecord& light) {
  const MovingLights& moving = *table.moving;
  const LightMotion& motion =
      moving
          .motions[static_cast<std::size_t>(moving.motion_of_light[static_cast<std::size_t>(light.profile)])];
  return std::span(moving.steps)
      .subspan(static_cast<std::size_t>(motion.first_step), static_cast<std::size_t>(motion.segments) + 1);
}

vec64::Vec column(const Affine& a, int c) { return {a.m[c], a.m[4 + c], a.m[8 + c]}; }

/// Columns of a matrix that maps normals times areas.
using Cofactors = std::array<vec64::Vec, 3>;

Cofactors cofactors(const Affine& a) {
  const vec64::Vec x = column(a, 0), y = column(a, 1), z = column(a, 2);
  const double side = dot(x, cross(y, z)) < 0 ? -1 : 1;
  return {cross(y, z) * side, cross(z, x) * side, cross(x, y) * side};
}

vec64::Vec mapped(const Cofactors& c, const vec64::Vec& n) { return c[0] * n[0] + c[1] * n[1] + c[2] * n[2]; }

/// How many times larger areas become, as a mean over the steps: exactly where all normals are `axis`, else
/// the root of the mean square over all directions.
double area_growth(std::span<const Affine> steps, bool flat, const vec64::Vec& axis) {
  double sum = 0;
  for (const Affine& step : steps) {
    const Cofactors c = cofactors(step);
    sum +=
        flat ? length(mapped(c, axis)) : std::sqrt((dot(c[0], c[0]) + dot(c[1], c[1]) + dot(c[2], c[2])) / 3);
  }
  return sum / static_cast<double>(steps.size());
}

/// Directions of which those between two steps are sums with positive weights. Normals are mapped by the
/// cofactors of a matrix that is linear in time, which are quadratic: three control points [Bezier].
std::vector<vec64::Vec> normals_on_the_way(std::span<const Affine> steps, const vec64::Vec& axis) {
  std::vector<vec64::Vec> normals;
  for (std::size_t k = 0; k < steps.size(); ++k) {
    const vec64::Vec here = mapped(cofactors(steps[k]), axis);
    if (k > 0) {
      Affine middle;
      for (int i = 0; i < 12; ++i) middle.m[i] = 0.5f * (steps[k - 1].m[i] + steps[k].m[i]);
      const vec64::Vec before = mapped(cofactors(steps[k - 1]), axis);
      normals.push_back(mapped(cofactors(middle), axis) * 2 - (before + here) * 0.5);
    }
    normals.push_back(here);
  }
  return normals;
}

/// Whether the steps only turn and shift.
bool is_rigid(std::span<const Affine> steps) {
  constexpr double kTolerance = 1e-3;
  return std::all_of(steps.begin(), steps.end(), [](const Affine& step) {
    const vec64::Vec x = column(step, 0), y = column(step, 1), z = column(step, 2);
    const double off = std::max({std::abs(dot(x, x) - 1), std::abs(dot(y, y) - 1), std::abs(dot(z, z) - 1),
                                 std::abs(dot(x, y)), std::abs(dot(y, z)), std::abs(dot(z, x))});
    return off <= kTolerance;
  });
}

/// A light of any kind that moves. `traits` are those of the kind.
class MovingLight final : public LightModel {
 public:
  explicit MovingLight(LightTraits model_traits) : LightModel(model_traits) {}

  LightSample sample(const LightTable& table, Int light, const Receiver& from, Vec2 u,
                     Mask active) const override {
    const MovedSpace space(*table.moving, light, from.time, active);
    LightSample s = sample_light(table.moving->still, light, space.receiver(from), u, active);
    const Vec3 w = transform_vector(space.to, s.wi);
    const Float stretch = length(w);
    s.wi = w * (1.0f / stretch);
    if (!single()) s.pdf = s.pdf / space.solid_angle(stretch);
    s.valid &= (s.pdf > 0.0f) & is_finite(s.pdf);
    if (traits.at_infinity) return s;
    if (single()) s.radiance *= 1.0f / sqr(stretch);
    const Float distance = s.distance * stretch;
    const Vec3 point = fma(s.wi, distance, from.p);
    if (!traits.delta) {
      const Surface surface = surface_at_point(table, light, space, from.time, point, s.barycentric, s.valid);
      s.cosine = abs(dot(surface.ng, s.wi));
    }
    s.distance = shortened(distance, space.error(from.p, point, distance), s.cosine);
    return s;
  }

  Float pdf(const LightTable& table, Int light, const Receiver& from, Vec3 wi, Vec3 point, Vec3 normal,
            Mask active) const override {
    if (single()) return 0.0f;
    const MovedSpace space(*table.moving, light, from.time, active);
    const Vec3 w = transform_vector(space.from, wi);
    const Float shrink = length(w);
    const Float found =
        light_pdf(table.moving->still, light, space.receiver(from), w * (1.0f / shrink),
                  transform_point(space.from, point), normalize(transform_normal(space.to, normal)), active);
    return found / space.solid_angle(1.0f / shrink);
  }

  Emission emit(const LightTable& table, Int light, Float time, Vec2 u_place, Vec2 u_direction,
                Mask active) const override {
    if (traits.at_infinity)
      return emit_from_infinity(*this, table, light, time, u_place, u_direction, active);
    const MovedSpace space(*table.moving, light, time, active);
    Emission ray = sample_emission(table.moving->still, light, time, u_place, u_direction, active);
    ray.origin = transform_point(space.to, ray.origin);
    const Vec3 w = transform_vector(space.to, ray.direction);
    const Float stretch = length(w);
    ray.direction = w * (1.0f / stretch);
    ray.flux *= single() ? space.solid_angle(stretch) : space.etendue(stretch);
    const Vec3 n = transform_normal(space.from, ray.normal);
    const Float l2 = length_squared(n);
    const Mask faces = l2 > 0.0f;
    const Float scale = select_or_zero(faces, 1.0f / sqrt(select(faces, l2, 1.0f)));
    ray.normal = n * scale;
    if (traits.delta) return ray;
    ray.offset = ray.normal * (length(transform_vector(space.to, ray.offset)) +
                               space.error(ray.origin, ray.origin, Float(0.0f)));
    if (table.any_textures)
      ray.flux = ray.flux * emission_texture(table, light, time, ray.origin, ray.barycentric, active);
    return ray;
  }

  EmissionDensity emission_density(const LightTable& table, Int light, Float time, Vec3 point, Float cosine,
                                   Vec3 direction, Mask active) const override {
    if (traits.at_infinity) {
      Receiver from(point);
      from.time = time;
      return {Float(kInvPi / (table.scene_radius * table.scene_radius)),
              single() ? Float(1.0f) : pdf(table, light, from, -direction, point, direction, active)};
    }
    const MovedSpace space(*table.moving, light, time, active);
    const Vec3 w = transform_vector(space.from, direction);
    const Float shrink = length(w), stretch = 1.0f / shrink;
    // Densities of directions go with the cosine, or do not look at it: that of render space will do, as
    // etendue has it.
    EmissionDensity density = tessera::render::TESSERA_ISA::emission_density(
        table.moving->still, light, time, transform_point(space.from, point), cosine, w * stretch, active);
    density.direction = density.direction / (single() ? space.solid_angle(stretch) : space.etendue(stretch));
    return density;
  }

  double power(const LightTable& table, const LightRecord& light) const override {
    const LightTable& still = table.moving->still;
    const LightRecord& own = still_record(table, light);
    const LightSource& model = still.sources(own.kind);
    const double power = model.power(still, own);
    return power * (traits.at_infinity ? scene_disk(table) / scene_disk(still) : growth(table, light));
  }

  LightBounds bounds(const LightTable& table, const LightRecord& light) const override {
    const LightTable& still = table.moving->still;
    const LightRecord& record = still_record(table, light);
    if (traits.at_infinity) return {};
    const LightBounds own = still.sources(record.kind).bounds(still, record);
    const std::span<const Affine> steps = steps_of(table, light);
    LightBounds b = own;
    b.low = LightBounds().low, b.high = LightBounds().high;
    for (const Affine& step : steps) {
      for (int corner = 0; corner < 8; ++corner) {
        const vec64::Vec p = {corner & 1 ? own.high[0] : own.low[0], corner & 2 ? own.high[1] : own.low[1],
                              corner & 4 ? own.high[2] : own.low[2]};
        b.add(column(step, 0) * p[0] + column(step, 1) * p[1] + column(step, 2) * p[2] + column(step, 3));
      }
    }
    b.intensity *= growth(table, light);
    if (!traits.delta && own.angle == 0) {
      set_cone(normals_on_the_way(steps, own.axis), 0, b);
    } else if (traits.delta && is_rigid(steps)) {
      std::vector<vec64::Vec> axes;
      for (const Affine& step : steps)
        axes.push_back(column(step, 0) * own.axis[0] + column(step, 1) * own.axis[1] +
                       column(step, 2) * own.axis[2]);
      set_cone(axes, own.angle, b);
    } else {
      b.angle = std::numbers::pi;
    }
    return b;
  }

 private:
  /// Lights that a receiver sees in one direction.
  bool single() const { return traits.delta && !traits.extended; }

  double growth(const LightTable& table, const LightRecord& light) const {
    if (traits.delta) return 1;
    const LightTable& still = table.moving->still;
    const LightRecord& own = still_record(table, light);
    const LightBounds b = still.sources(own.kind).bounds(still, own);
    return area_growth(steps_of(table, light), b.angle == 0, b.axis);
  }

  /// The surface of a light on a shape, at a point near it.
  static Surface surface_at_point(const LightTable& table, Int light, const MovedSpace& space, Float time,
                                  Vec3 point, Vec2 barycentric, Mask active) {
    const auto field = [&](std::int32_t LightRecord::*member) {
      return gather_member(table.lights.data(), member, light, active);
    };
    const Hit hit{Float(0.0f),
                  barycentric.x,
                  barycentric.y,
                  field(&LightRecord::primitive),
                  field(&LightRecord::shape),
                  space.instance,
                  time};
    const Vec3 zero{Float(0.0f), Float(0.0f), Float(0.0f)};
    return surface_at(*table.shapes, hit, point, zero, active, false);
  }
};

}  // namespace

const ModelOf<MovingLight> moving_surface(LightKind::kMovingSurface, LightTraits{.uses_normals = true});
const ModelOf<MovingLight> moving_point(LightKind::kMovingPoint, LightTraits{.delta = true});
const ModelOf<MovingLight> moving_soft(LightKind::kMovingSoft, LightTraits{.delta = true, .extended = true});
const ModelOf<MovingLight> moving_distant(LightKind::kMovingDistant,
                                          LightTraits{.at_infinity = true, .delta = true});
const ModelOf<MovingLight> moving_infinite(LightKind::kMovingInfinite, LightTraits{.at_infinity = true});

Color environment_radiance(const LightTable& table, int light, const Receiver& from, Vec3 wi, Mask active) {
  if (table.lights[static_cast<std::size_t>(light)].kind != LightKind::kMovingInfinite)
    return still_environment_radiance(table, light, from, wi, active);
  const MovedSpace space(*table.moving, Int(light), from.time, active);
  return still_environment_radiance(table.moving->still, light, space.receiver(from),
                                    normalize(transform_vector(space.from, wi)), active);
}

}  // namespace tessera::render::TESSERA_ISA
