// Panoramas: columns are even in longitude, rows in the tangent of the latitude, +y up, so that upright lines
// are straight. A place is the longitude from the axis, to the right, and that tangent.
#include "render/sensor/model/about_point.h"

namespace tessera::render::TESSERA_ISA {

namespace {

class CylindricalSensor final : public SensorModel {
 public:
  CylindricalSensor() : SensorModel(kAboutPoint) {}

  LocalRay start(const SensorRecord&, Vec2 place, Vec2) const override {
    return {sensor_origin(), {sin(place.x), place.y, cos(place.x)}};
  }
  LocalConnection connect(const SensorRecord& sensor, Vec3 point, Vec2) const override {
    const Float across = max(sqrt(sqr(point.x) + sqr(point.z)), 1e-30f);
    const Float secant = length(point) / across;  // of the latitude
    return from_point(sensor, point, {atan2(point.x, point.z), point.y / across}, secant * secant * secant);
  }
  Float pixel_width(const SensorRecord& sensor, Float distance) const override {
    return distance * pixel_step(sensor);
  }
};

}  // namespace

const ModelOf<CylindricalSensor> cylindrical(SensorKind::kCylindrical);

}  // namespace tessera::render::TESSERA_ISA
