#include "render/light/light.h"
#include "render/light/positional_light.h"
#include "render/light/sphere_cone.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// A point or spot light whose rays come from a sphere instead of its centre.
///
/// The surface of the sphere sends intensity / (2 pi r^2) to both sides, and light goes through it. So a ray
/// that meets it from outside has the light of the near wall and of the far one, together intensity /
/// (pi r^2), and whatever stands within the sphere shadows the far wall alone; from inside, there is one
/// wall. Profiles are held against the directions of rays, as if these began at the centre: from afar the
/// intensity is the point's.
class SoftLight final : public LightModel {
 public:
  /// `point`: the kind that it is but for its size.
  explicit SoftLight(LightKind point) : LightModel({.delta = true, .extended = true}), point_(point) {}

  /// Directions that meet the sphere, uniformly, and one of the two walls; from inside, all directions.
  LightSample sample(const LightTable& table, Int light, const Receiver& from, Vec2 u,
                     Mask active) const override {
    const LightLanes lanes{table, light, active};
    const Cone c = seen_from(lanes, from.p);
    const Mask behind = u.y >= 0.5f, far = behind | ~c.usable;
    u.y = select(c.usable, 2.0f * u.y - select(behind, Float(1.0f), Float(0.0f)), u.y);
    const Chord chord = sample_chord(c, one_minus_cos_max(c), u);
    const Float distance = select(far, chord.far_end(), chord.near_end(c));
    LightSample s;
    s.wi = chord.wi;
    s.distance =
        shortened(distance, ray_end_error(from.p, fma(s.wi, distance, from.p), c.radius, distance), 1.0f);
    s.radiance = lanes.radiance() * (kInv2Pi / sqr(c.radius));
    s.pdf = density(c);
    s.valid = and_not(active & is_finite(s.distance), is_black(s.radiance));
    s.delta = active;
    s.cosine = chord.half_length / c.radius;
    model().apply_profile(lanes, s);
    return s;
  }

  Float pdf(const LightTable& table, Int light, const Receiver& from, Vec3, Vec3, Vec3,
            Mask active) const override {
    return density(seen_from({table, light, active}, from.p));
  }

  /// The point's ray, which begins anywhere on the disk that the sphere is across the ray, on either wall.
  Emission emit(const LightTable& table, Int light, Float time, Vec2 u_place, Vec2 u_direction,
                Mask active) const override {
    Emission ray = model().emit(table, light, time, u_place, u_direction, active);
    const Mask behind = u_place.x >= 0.5f;
    u_place.x = 2.0f * u_place.x - select(behind, Float(1.0f), Float(0.0f));
    ray.normal = Frame::from_normal(ray.direction).to_world(square_to_cosine_hemisphere(u_place));
    // The far wall has its normal inwards.
    const Vec3 outwards = select(behind, -ray.normal, ray.normal);
    ray.origin = fma(outwards, LightLanes{table, light, active}.field(&LightRecord::radius), ray.origin);
    return ray;
  }

  EmissionDensity emission_density(const LightTable& table, Int light, Float time, Vec3 point, Float cosine,
                                   Vec3 direction, Mask active) const override {
    EmissionDensity density = model().emission_density(table, light, time, point, cosine, direction, active);
    // Floats hold the inverse.
    constexpr float kLeastArea = 1e-30f;
    const Float radius = LightLanes{table, light, active}.field(&LightRecord::radius);
    density.place = abs(cosine) * (kInv2Pi / max(sqr(radius), kLeastArea));
    return density;
  }

  double power(const LightTable& table, const LightRecord& light) const override {
    return model().power(table, light);
  }

  LightBounds bounds(const LightTable& table, const LightRecord& light) const override {
    LightBounds b = model().bounds(table, light);
    const double r = light.radius;
    b.add(b.low - vec64::Vec{r, r, r});
    b.add(b.high + vec64::Vec{r, r, r});
    return b;
  }

 private:
  /// The sphere, no smaller than the rounding of a shadow ray's end, so that floats hold its density.
  static Cone seen_from(const LightLanes& lanes, Vec3 reference) {
    constexpr float kLeastAngle = 0x1p-20f;
    const Vec3 centre = lanes.field3(&LightRecord::position);
    const Float radius = max(lanes.field(&LightRecord::radius), kLeastAngle * length(centre - reference));
    return cone(centre, radius, reference, lanes.active);
  }
  static Float one_minus_cos_max(const Cone& c) { return select(c.usable, c.one_minus_cos_max, 2.0f); }
  /// Density of a direction and a wall.
  static Float density(const Cone& c) {
    return cone_pdf(one_minus_cos_max(c)) * select(c.usable, Float(0.5f), Float(1.0f));
  }

  const PositionalLight& model() const { return static_cast<const PositionalLight&>(light_model(point_)); }

  const LightKind point_;
};

}  // namespace

const ModelOf<SoftLight> soft_point(LightKind::kSoftPoint, LightKind::kPoint);
const ModelOf<SoftLight> soft_spot(LightKind::kSoftSpot, LightKind::kSpot);

}  // namespace tessera::render::TESSERA_ISA
