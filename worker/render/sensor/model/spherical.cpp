// Sensors that see all around, +y up [pbrt-v4 SphericalCamera]; places are points of the unit square.
#include <cmath>

#include "render/core/constants.h"
#include "render/sampling/sphere_map.h"
#include "render/sensor/model/flat_raster.h"

namespace tessera::render::TESSERA_ISA {

namespace {

constexpr SensorModel::Traits kAllAround{.connects = false, .has_axis = false};

/// Columns are even in longitude, rows in latitude.
class EquirectangularSensor final : public SensorModel {
 public:
  EquirectangularSensor() : SensorModel(kAllAround) {}

  LocalRay start(const SensorRecord&, Vec2 square, Vec2) const override {
    const Float theta = kPi * square.y, phi = 2.0f * kPi * square.x;
    const Float sin_theta = sin(theta);
    return {sensor_origin(), {sin_theta * cos(phi), cos(theta), sin_theta * sin(phi)}};
  }
  Float pixel_width(const SensorRecord& sensor, Float distance) const override {
    return distance * (2 * kPi * pixel_step(sensor));
  }
};

/// All pixels see the same solid angle.
class OctahedralSensor final : public SensorModel {
 public:
  OctahedralSensor() : SensorModel(kAllAround) {}

  LocalRay start(const SensorRecord&, Vec2 square, Vec2) const override {
    // Pixel filters reach beyond the square; it goes on mirrored there.
    const auto fold = [](Float x) { return 1.0f - abs(1.0f - abs(x)); };
    const Vec3 w = direction_from_octahedral({fold(square.x), fold(square.y)});
    return {sensor_origin(), {w.x, w.z, w.y}};
  }
  Float pixel_width(const SensorRecord& sensor, Float distance) const override {
    return distance * (2 * std::sqrt(kPi) * pixel_step(sensor));  // the square is mapped to 4 pi steradians
  }
};

}  // namespace

const ModelOf<EquirectangularSensor> equirectangular(SensorKind::kEquirectangular);
const ModelOf<OctahedralSensor> octahedral(SensorKind::kOctahedral);

}  // namespace tessera::render::TESSERA_ISA
