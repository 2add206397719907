// Sensors that see all around, +y up [pbrt-v4 SphericalCamera]; places are points of the unit square.
#include <cmath>

#include "render/core/constants.h"
#include "render/sampling/sphere_map.h"
#include "render/sensor/model/about_point.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// Columns are even in longitude, rows in latitude.
class EquirectangularSensor final : public SensorModel {
 public:
  EquirectangularSensor() : SensorModel(kAboutPoint) {}

  LocalRay start(const SensorRecord&, Vec2 square, Vec2) const override {
    const Float theta = kPi * square.y, phi = 2.0f * kPi * square.x;
    const Float sin_theta = sin(theta);
    return {sensor_origin(), {sin_theta * cos(phi), cos(theta), sin_theta * sin(phi)}};
  }
  LocalConnection connect(const SensorRecord& sensor, Vec3 point, Vec2) const override {
    const Float across = sqrt(sqr(point.x) + sqr(point.z));
    const Float turn = atan2(point.z, point.x) * kInv2Pi;
    const Vec2 square{select(turn < 0.0f, turn + 1.0f, turn), atan2(across, point.y) * kInvPi};
    // A pixel has less solid angle the nearer it is to a pole.
    const Float sin_theta = across / max(length(point), 1e-30f);
    return from_point(sensor, point, square, 1.0f / (max(sin_theta, 1e-6f) * (2 * kPi * kPi)));
  }
  Float pixel_width(const SensorRecord& sensor, Float distance) const override {
    return distance * (2 * kPi * pixel_step(sensor));
  }
};

/// Columns are even in longitude, rows in the height over the unit sphere's equator: all pixels see the same
/// solid angle [Lambert 1772].
class EqualAreaCylindricalSensor final : public SensorModel {
 public:
  EqualAreaCylindricalSensor() : SensorModel(kAboutPoint) {}

  LocalRay start(const SensorRecord&, Vec2 square, Vec2) const override {
    // Beyond a pole, the meridian is the opposite one (RasterEdges::kOverPole).
    const Mask over = (square.y < 0.0f) | (square.y > 1.0f);
    const Float row = select(over, 1.0f - abs(1.0f - abs(square.y)), square.y);
    const Float phi = 2.0f * kPi * (square.x + select_or_zero(over, Float(0.5f)));
    const Float sin_theta = 2.0f * safe_sqrt(row * (1.0f - row));
    return {sensor_origin(), {sin_theta * cos(phi), 1.0f - 2.0f * row, sin_theta * sin(phi)}};
  }
  LocalConnection connect(const SensorRecord& sensor, Vec3 point, Vec2) const override {
    const Float turn = atan2(point.z, point.x) * kInv2Pi;
    const Float distance = max(length(point), 1e-30f);
    // Half of 1 - cos, by the half that keeps its digits.
    const Float across = (sqr(point.x) + sqr(point.z)) / sqr(distance);
    const Float near_pole = 0.5f * across / (1.0f + abs(point.y) / distance);
    const Vec2 square{select(turn < 0.0f, turn + 1.0f, turn),
                      select(point.y > 0.0f, near_pole, 1.0f - near_pole)};
    return from_point(sensor, point, square, Float(1 / (4 * kPi)));
  }
  Float pixel_width(const SensorRecord& sensor, Float distance) const override {
    return distance * std::max(2 * kPi * std::abs(sensor.scale_x), 2 * std::abs(sensor.scale_y));
  }
};

/// All pixels see the same solid angle.
class OctahedralSensor final : public SensorModel {
 public:
  OctahedralSensor() : SensorModel(kAboutPoint) {}

  LocalRay start(const SensorRecord&, Vec2 square, Vec2) const override {
    // Pixel filters reach beyond the square; it goes on mirrored there (RasterEdges::kMirrored).
    const auto fold = [](Float x) { return 1.0f - abs(1.0f - abs(x)); };
    const Vec3 w = direction_from_octahedral({fold(square.x), fold(square.y)});
    return {sensor_origin(), {w.x, w.z, w.y}};
  }
  LocalConnection connect(const SensorRecord& sensor, Vec3 point, Vec2) const override {
    const Vec3 w = point * (1.0f / max(length(point), 1e-30f));
    return from_point(sensor, point, octahedral_from_direction({w.x, w.z, w.y}), Float(1 / (4 * kPi)));
  }
  Float pixel_width(const SensorRecord& sensor, Float distance) const override {
    return distance * (2 * std::sqrt(kPi) * pixel_step(sensor));  // the square is mapped to 4 pi steradians
  }
};

}  // namespace

const ModelOf<EquirectangularSensor> equirectangular(SensorKind::kEquirectangular);
const ModelOf<EqualAreaCylindricalSensor> equal_area_cylindrical(SensorKind::kEqualAreaCylindrical);
const ModelOf<OctahedralSensor> octahedral(SensorKind::kOctahedral);

}  // namespace tessera::render::TESSERA_ISA
