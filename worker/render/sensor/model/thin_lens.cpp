// A thin lens [Kolb, Mitchell & Hanrahan 1995]: all rays of one place of the raster meet on the plane of
// focus.
#include "render/sensor/model/aperture.h"
#include "render/sensor/model/flat_raster.h"

namespace tessera::render::TESSERA_ISA {

namespace {

class ThinLensSensor final : public SensorModel {
 public:
  ThinLensSensor() : SensorModel({.has_lens = true}) {}

  LocalRay start(const SensorRecord& sensor, Vec2 place, Vec2 u_lens) const override {
    const Vec3 lens = point_of_lens(sensor, u_lens), through{place.x, place.y, Float(1.0f)};
    LocalRay ray{lens, through * Float(sensor.focal_distance) - lens};
    ray.valid = leaves_barrel(sensor, lens, ray.direction);
    return ray;
  }
  LocalConnection connect(const SensorRecord& sensor, Vec3 point, Vec2 u_lens) const override {
    // Where the ray from the lens meets the plane of focus, seen from the middle of the lens.
    const Vec3 lens = point_of_lens(sensor, u_lens);
    const Float t = sensor.focal_distance / point.z;
    const Vec2 place{(lens.x + (point.x - lens.x) * t) * (1 / sensor.focal_distance),
                     (lens.y + (point.y - lens.y) * t) * (1 / sensor.focal_distance)};
    LocalConnection connection = through_plane(sensor, point, place, lens);
    connection.valid = leaves_barrel(sensor, lens, point - lens);
    return connection;
  }
  Float pixel_width(const SensorRecord& sensor, Float distance) const override {
    return distance * pixel_step(sensor);
  }
};

}  // namespace

const ModelOf<ThinLensSensor> thin_lens(SensorKind::kThinLens);

}  // namespace tessera::render::TESSERA_ISA
