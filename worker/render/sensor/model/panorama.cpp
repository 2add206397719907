// Longitude and latitude from the sensor's axis, and stereo of all directions: each eye goes around on a
// circle and looks outwards along its tangents, so that every direction has a pair of eyes that stands square
// to it [Peleg, Ben-Ezra & Pritch 2001, Omnistereo: Panoramic Stereo Imaging]. A place is the longitude, to
// the right, and the latitude, upwards, in radians.
#include "render/core/constants.h"
#include "render/sensor/model/about_point.h"
#include "render/sensor/model/panorama_place.h"
#include "render/sensor/panorama_table.h"

namespace tessera::render::TESSERA_ISA {

namespace {

constexpr float kHalfPi = kPi / 2;

/// Distance of an eye that looks at this latitude from the middle, and the derivative by the latitude.
struct EyeAt {
  Float radius, slope;
};
EyeAt eye_at(const CircleOfEyes& eyes, Float latitude) {
  const float per_radian = kHalfPi / (eyes.merge_to - eyes.merge_from);
  const Float angle = clamp((abs(latitude) - eyes.merge_from) * per_radian, 0.0f, kHalfPi);
  const Mask merging = (angle > 0.0f) & (angle < kHalfPi);
  return {select_or_zero(angle < kHalfPi, cos(angle) * eyes.radius),
          copysign(select_or_zero(merging, sin(angle) * (eyes.radius * per_radian)), -latitude) *
              (eyes.radius < 0 ? -1.0f : 1.0f)};
}

/// Rays of one latitude are the same in the frames of their longitudes, whose x is to the right and whose z
/// is ahead: their points at `t` are (eye (1 - t inverse_convergence), t sin, t cos).
class PanoramaSensor final : public SensorModel {
 public:
  PanoramaSensor() : SensorModel({.has_axis = false, .may_fail = true}) {}

  LocalRay start(const SensorRecord& sensor, Vec2 place, Vec2) const override {
    const Bearing bearing = bearing_of(place);
    const CircleOfEyes& eyes = sensor.panorama->eyes;
    const Float radius = eye_at(eyes, bearing.latitude).radius;
    const Float s = sin(bearing.longitude), c = cos(bearing.longitude), across = cos(bearing.latitude);
    LocalRay ray;
    ray.origin = {radius * c, Float(0.0f), radius * s * -1.0f};
    ray.direction =
        fma(ray.origin, -eyes.inverse_convergence, Vec3{across * s, sin(bearing.latitude), across * c});
    ray.valid = bearing.valid;
    return ray;
  }

  LocalConnection connect(const SensorRecord& sensor, Vec3 point, Vec2) const override {
    const CircleOfEyes& eyes = sensor.panorama->eyes;
    const Float across = sqrt(sqr(point.x) + sqr(point.z));
    const Meeting met = meet(eyes, across, point.y);
    const float k = eyes.inverse_convergence;
    const Float beside = met.eye.radius * (1.0f - met.t * k), ahead = met.t * met.cosine;
    const Float turn = atan2(point.x, point.z) - atan2(beside, ahead);
    const Float longitude = longitude_in_picture(sensor, turn);
    // Area across the ray of what a step in longitude and one in latitude span.
    const Vec3 by_longitude{ahead, Float(0.0f), -beside},
        by_latitude{met.eye.slope * (1.0f - met.t * k), ahead, met.t * met.sine * -1.0f},
        along{met.eye.radius * -k, met.sine, met.cosine};
    const Float area = abs(dot(cross(by_longitude, by_latitude), normalize(along)));
    const Float density = 1.0f / (max(area, 1e-30f) * pixel_area(sensor));
    const Float s = sin(longitude), c = cos(longitude);
    return {{longitude, atan2(met.sine, met.cosine)},
            {met.eye.radius * c, Float(0.0f), met.eye.radius * s * -1.0f},
            density,
            density,
            met.valid};
  }

  Float pixel_width(const SensorRecord& sensor, Float distance) const override {
    return distance * pixel_step(sensor);
  }

 private:
  /// The latitude whose ray goes through a point, and the ray's parameter there.
  struct Meeting {
    Float t, sine, cosine;
    EyeAt eye;
    Mask valid;
  };

  /// `across` and `height`: the point's, from the axis and above the eyes.
  static Meeting meet(const CircleOfEyes& eyes, Float across, Float height) {
    // Squared distances of the point from the middle, of which `t` is a function that grows, are
    //   t^2 + eye^2 (1 - t k)^2, where the eye is a function of the sine height / t.
    const Float squared = sqr(across) + sqr(height), most = abs(height);
    const float k = eyes.inverse_convergence, widest = eyes.radius < 0 ? -eyes.radius : eyes.radius;
    Meeting met;
    if (widest == 0) {
      met.t = sqrt(squared);
      met.eye = {Float(0.0f), Float(0.0f)};
      met.valid = met.t > 0.0f;
    } else {
      Float low = most, high = sqrt(squared) + widest;
      met.t = max(sqrt(squared), most);
      const auto latitude_at = [&](Float t) { return asin(clamp(height / max(t, 1e-30f), -1.0f, 1.0f)); };
      constexpr int kSteps = 24;
      for (int i = 0; i < kSteps; ++i) {
        const Float latitude = latitude_at(met.t);
        const EyeAt eye = eye_at(eyes, latitude);
        const Float rest = 1.0f - met.t * k;
        const Float error = fma(met.t, met.t, sqr(eye.radius * rest)) - squared;
        high = select(error >= 0.0f, met.t, high), low = select(error < 0.0f, met.t, low);
        // The latitude's derivative by t is -tan / t.
        const Float sine = height / max(met.t, 1e-30f), cosine = max(safe_sqrt(1.0f - sqr(sine)), 1e-4f);
        const Float eye_by_t = eye.slope * -(sine / (cosine * max(met.t, 1e-30f)));
        const Float slope = 2.0f * (met.t + eye.radius * rest * (eye_by_t * rest - eye.radius * k));
        const Float next = met.t - error / select(abs(slope) > 1e-20f, slope, Float(1e-20f));
        const Mask inside = (next > low) & (next < high);
        met.t = select(inside, next, 0.5f * (low + high));
      }
      met.eye = eye_at(eyes, latitude_at(met.t));
      const Float error = fma(met.t, met.t, sqr(met.eye.radius * (1.0f - met.t * k))) - squared;
      met.valid = (met.t > 0.0f) & (abs(error) <= 1e-4f * squared);
    }
    met.sine = clamp(height / max(met.t, 1e-30f), -1.0f, 1.0f);
    // The distance from the axis keeps its digits towards the poles.
    const Float beside = met.eye.radius * (1.0f - met.t * k);
    const Float ahead = sqr(across) - sqr(beside);
    met.cosine = safe_sqrt(ahead) / max(met.t, 1e-30f);
    // Nothing sees the inside of the circle, nor what is above it where eyes do not merge.
    met.valid &= ahead > 1e-5f * sqr(beside);
    return met;
  }
};

}  // namespace

const ModelOf<PanoramaSensor> panorama(SensorKind::kPanorama);

}  // namespace tessera::render::TESSERA_ISA
