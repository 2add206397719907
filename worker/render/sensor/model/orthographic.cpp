// Parallel rays; with a lens, those through one point of it are, and all rays of one place of the raster meet
// on the plane of focus.
#include "render/core/affine.h"
#include "render/sensor/model/aperture.h"
#include "render/sensor/model/flat_raster.h"

namespace tessera::render::TESSERA_ISA {

namespace {

class OrthographicSensor final : public SensorModel {
 public:
  explicit OrthographicSensor(bool with_lens) : SensorModel({.has_lens = with_lens}) {}

  LocalRay start(const SensorRecord& sensor, Vec2 place, Vec2 u_lens) const override {
    const Vec3 origin{place.x, place.y, Float(0.0f)};
    if (!traits.has_lens) return {origin, {Float(0.0f), Float(0.0f), Float(1.0f)}};
    const Vec3 focus{place.x, place.y, Float(sensor.focal_distance)};
    const Vec3 lens = origin + point_of_lens(sensor, u_lens);
    return {lens, focus - lens};
  }
  LocalConnection connect(const SensorRecord& sensor, Vec3 point, Vec2 u_lens) const override {
    Vec3 lens = sensor_origin();
    Vec2 place{point.x, point.y};
    if (traits.has_lens) {
      lens = point_of_lens(sensor, u_lens);
      const Float spread = 1.0f - point.z * (1 / sensor.focal_distance);
      place = {point.x - lens.x * spread, point.y - lens.y * spread};
    }
    lens = {lens.x + place.x, lens.y + place.y, Float(0.0f)};
    const Float cosine = point.z / sqrt(length_squared(point - lens));
    const Float density = 1.0f / (cosine * pixel_area(sensor));
    return {place, lens, density, density};
  }
  Float pixel_width(const SensorRecord& sensor, Float) const override {
    return length(
        transform_vector(sensor.render_from_sensor, {Float(pixel_step(sensor)), Float(0.0f), Float(0.0f)}));
  }
};

}  // namespace

const ModelOf<OrthographicSensor> orthographic(SensorKind::kOrthographic, false);
const ModelOf<OrthographicSensor> orthographic_lens(SensorKind::kOrthographicLens, true);

}  // namespace tessera::render::TESSERA_ISA
