// All rays begin at one point.
#include "render/sensor/model/flat_raster.h"

namespace tessera::render::TESSERA_ISA {

namespace {

class PinholeSensor final : public SensorModel {
 public:
  PinholeSensor() : SensorModel({}) {}

  LocalRay start(const SensorRecord&, Vec2 place, Vec2) const override {
    return {sensor_origin(), {place.x, place.y, Float(1.0f)}};
  }
  LocalConnection connect(const SensorRecord& sensor, Vec3 point, Vec2) const override {
    return through_plane(sensor, point, {point.x / point.z, point.y / point.z}, sensor_origin());
  }
  Float pixel_width(const SensorRecord& sensor, Float distance) const override {
    return distance * pixel_step(sensor);
  }
};

}  // namespace

const ModelOf<PinholeSensor> pinhole(SensorKind::kPinhole);

}  // namespace tessera::render::TESSERA_ISA
