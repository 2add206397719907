// A thin lens that is turned against the film [Scheimpflug 1904; Merklinger 1996, Focusing the View Camera].
// Rays of a place through the middle of the lens go on straight, so that perspective is the pinhole's. The
// thin lens equation along the lens's own axis puts their focus where dot(plane, X) = 1.
#include "render/sensor/model/aperture.h"
#include "render/sensor/model/flat_raster.h"

namespace tessera::render::TESSERA_ISA {

namespace {

Vec3 broadcast(const float (&v)[3]) { return {Float(v[0]), Float(v[1]), Float(v[2])}; }

Vec3 point_of_tilted_lens(const SensorRecord& sensor, Vec2 u_lens) {
  const LensTilt& tilt = sensor.lens->tilt;
  const Vec3 flat = point_of_lens(sensor, u_lens);
  return fma(broadcast(tilt.across_x), flat.x, broadcast(tilt.across_y) * flat.y);
}

class TiltedLensSensor final : public SensorModel {
 public:
  TiltedLensSensor() : SensorModel({.has_lens = true}) {}

  LocalRay start(const SensorRecord& sensor, Vec2 place, Vec2 u_lens) const override {
    // The focus is (x, y, 1) / dot(plane, (x, y, 1)); where that is beyond infinity, rays diverge.
    const Vec3 lens = point_of_tilted_lens(sensor, u_lens), through{place.x, place.y, Float(1.0f)};
    return {lens, through - lens * dot(broadcast(sensor.lens->tilt.plane), through)};
  }

  LocalConnection connect(const SensorRecord& sensor, Vec3 point, Vec2 u_lens) const override {
    const Vec3 lens = point_of_tilted_lens(sensor, u_lens), way = point - lens;
    const Vec3 plane = broadcast(sensor.lens->tilt.plane);
    // The way is `along` times the direction that start() gives: solved for (x, y, 1). The matrix that leads
    // from there to the direction is I - lens plane^T, whose determinant is `beside`.
    const Float beside = 1.0f - dot(plane, lens);
    const Vec3 scaled = fma(lens, dot(plane, way) / beside, way);
    const Float along = scaled.z, inverse = 1.0f / along;
    const Float density = length(way) * (inverse * inverse * inverse) / (beside * pixel_area(sensor));
    return {{scaled.x * inverse, scaled.y * inverse}, lens, density, density, along > 0.0f};
  }

  Float pixel_width(const SensorRecord& sensor, Float distance) const override {
    return distance * pixel_step(sensor);
  }
};

}  // namespace

const ModelOf<TiltedLensSensor> tilted_lens(SensorKind::kTiltedLens);

}  // namespace tessera::render::TESSERA_ISA
