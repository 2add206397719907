// Fisheyes: the distance of a place from the axis is a function of the angle there. Four of them are usual
// [Kannala and Brandt 2006, A generic camera model]; a focal length is one.
#include "render/core/constants.h"
#include "render/sensor/model/about_point.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// Each mapping says at which angle from the axis a place at this distance from it sees, which distance the
/// angle whose sine and cosine these are has, and how much area of places one steradian has there.
struct Equidistant {
  static constexpr float kMostDistance = kPi;
  static Float angle_at(Float distance) { return distance; }
  static Float distance_at(Float sine, Float cosine) { return atan2(sine, cosine); }
  static Float places(Float sine, Float cosine) {
    const Float angle = atan2(sine, cosine);
    return select(sine > 1e-4f, angle / max(sine, 1e-4f), select(cosine > 0.0f, Float(1.0f), angle * 1e4f));
  }
};
struct Equisolid {
  static constexpr float kMostDistance = 2;
  static Float angle_at(Float distance) { return 2.0f * asin(min(distance * 0.5f, Float(1.0f))); }
  static Float distance_at(Float, Float cosine) { return safe_sqrt(2.0f - 2.0f * cosine); }
  static Float places(Float, Float) { return Float(1.0f); }
};
struct Stereographic {
  static constexpr float kMostDistance = 1e6f;
  static Float angle_at(Float distance) { return 2.0f * atan(distance * 0.5f); }
  static Float distance_at(Float sine, Float cosine) {
    // 2 tan(angle / 2), by the half that keeps its digits.
    return select(cosine > 0.0f, 2.0f * sine / (1.0f + cosine), 2.0f * (1.0f - cosine) / max(sine, 1e-6f));
  }
  static Float places(Float, Float cosine) { return sqr(2.0f / max(1.0f + cosine, 1e-12f)); }
};
struct Orthographic {
  static constexpr float kMostDistance = 1;
  static Float angle_at(Float distance) { return asin(min(distance, Float(1.0f))); }
  static Float distance_at(Float sine, Float) { return sine; }
  static Float places(Float, Float cosine) { return max(cosine, 0.0f); }
};

template <class Mapping>
class FisheyeSensor final : public SensorModel {
 public:
  FisheyeSensor() : SensorModel({.has_axis = false, .may_fail = true}) {}

  LocalRay start(const SensorRecord& sensor, Vec2 place, Vec2) const override {
    const Float distance = sqrt(sqr(place.x) + sqr(place.y));
    const Float angle = Mapping::angle_at(distance);
    const Float part = sin(angle) / max(distance, 1e-30f);
    LocalRay ray{sensor_origin(),
                 {select(distance > 0.0f, place.x * part, 0.0f),
                  select(distance > 0.0f, place.y * part, 0.0f), cos(angle)}};
    ray.valid = (distance <= Mapping::kMostDistance) & (angle <= sensor.circle_angle);
    return ray;
  }
  LocalConnection connect(const SensorRecord& sensor, Vec3 point, Vec2) const override {
    const Vec3 w = point * (1.0f / max(length(point), 1e-30f));
    const Float sine = sqrt(sqr(w.x) + sqr(w.y));
    const Float distance = Mapping::distance_at(sine, w.z);
    const Float part = select_or_zero(sine > 0.0f, distance / max(sine, 1e-30f));
    LocalConnection found = from_point(sensor, point, {w.x * part, w.y * part}, Mapping::places(sine, w.z));
    found.valid = (distance <= Mapping::kMostDistance) & (atan2(sine, w.z) <= sensor.circle_angle);
    // With the orthographic one, things behind would fall on those before.
    if (Mapping::kMostDistance == 1) found.valid &= w.z > 0.0f;
    return found;
  }
  Float pixel_width(const SensorRecord& sensor, Float distance) const override {
    return distance * pixel_step(sensor);
  }
};

}  // namespace

const ModelOf<FisheyeSensor<Equidistant>> equidistant(SensorKind::kFisheyeEquidistant);
const ModelOf<FisheyeSensor<Equisolid>> equisolid(SensorKind::kFisheyeEquisolid);
const ModelOf<FisheyeSensor<Stereographic>> stereographic(SensorKind::kFisheyeStereographic);
const ModelOf<FisheyeSensor<Orthographic>> orthographic_fisheye(SensorKind::kFisheyeOrthographic);

}  // namespace tessera::render::TESSERA_ISA
