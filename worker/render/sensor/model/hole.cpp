// A round hole of some size instead of a lens. Where light is a ray, a place of the film sees all that is
// behind the hole from there. Where it is a wave, a point of the scene is spread over the film by Fresnel's
// diffraction [Born & Wolf 1999, section 8.8]; rays are sampled by that spread, and leave from the point of
// the hole that a straight ray to the same place of the film would have gone through, or from its edge
// beyond, so that blur is right at all distances and diffraction at the table's.
#include <algorithm>

#include "render/sampling/warp.h"
#include "render/sensor/hole_table.h"
#include "render/sensor/model/flat_raster.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// The radius, in the table's unit, within which a part of the light falls at the wavelength of a row.
Float radius_in_row(const HoleTable& hole, Float part, Int row) {
  const float* const light = hole.light.data();
  const Int first = row * kHoleNodes;
  static_assert(kHoleNodes == 1025);
  Int low = first;
  for (std::int32_t step = kHoleNodes / 2; step > 0; step /= 2) {
    const Int middle = low + step;
    low = select(gather(light, middle, Mask::all()) <= part, middle, low);
  }
  const Float before = gather(light, low, Mask::all()), behind = gather(light, low + 1, Mask::all());
  const Float along = clamp((part - before) / max(behind - before, 1e-30f), 0.0f, 1.0f);
  const Float node = to_float(low - first), reach = gather(hole.reach.data(), row, Mask::all());
  // Near the middle, light is even between two radii; far outside, it falls as 1 / radius^3.
  const Float inside = node * (1.0f / kHoleNearSteps), outside = inside + 1.0f / kHoleNearSteps;
  const Float near = sqrt(fma(along, sqr(outside) - sqr(inside), sqr(inside)));
  const Float inverse = (static_cast<float>(kHoleNodes - 1) - node - along) * (1.0f / kHoleFarSteps);
  return reach * select(node < static_cast<float>(kHoleNearSteps), near, 1.0f / max(inverse, 1e-6f));
}

/// The same between two wavelengths of the table.
Float radius_at(const HoleTable& hole, Float part, Float nm) {
  if (hole.wavelengths == 1) return radius_in_row(hole, part, Int(0));
  const Float place =
      clamp((nm - hole.first_nm) * hole.wavelengths_per_nm, 0.0f, static_cast<float>(hole.wavelengths - 1));
  const Int row = min(to_int(place), hole.wavelengths - 2);
  const Float low = radius_in_row(hole, part, row), high = radius_in_row(hole, part, row + 1);
  return fma(place - to_float(row), high - low, low);
}

/// A way through the hole.
struct HoleWay {
  Vec3 point;  // of the hole, sensor space
  Vec2 turn;   // of the ray's direction (z = 1) from that through the middle
};
HoleWay way_through(const HoleTable& hole, Vec2 u_lens, Float nm) {
  const Polar disk = square_to_disk_polar(u_lens);
  const Float radius = hole.light.empty() ? disk.radius : radius_at(hole, sqr(disk.radius), nm);
  const Float within = min(radius, 1.0f);
  const Float turn = radius * hole.spread - within * hole.inward, out = within * hole.radius;
  const Float c = cos(disk.angle), s = sin(disk.angle);
  return {{out * c, out * s, Float(0.0f)}, {turn * c, turn * s}};
}

/// The film's irradiance by what comes from this direction (z = 1), for each unit of solid angle.
Float weight_of(const HoleTable& hole, Float x, Float y) { return hole.weight / sqr(1.0f + sqr(x) + sqr(y)); }

class HoleSensor final : public SensorModel {
 public:
  HoleSensor() : SensorModel({.has_lens = true, .weighs = true}) {}

  LocalRay start(const SensorRecord& sensor, Vec2 place, Vec2 u_lens) const override {
    return start_dispersed(sensor, place, u_lens, Float(kMiddleNm));
  }
  LocalRay start_dispersed(const SensorRecord& sensor, Vec2 place, Vec2 u_lens,
                           Float wavelength) const override {
    const HoleTable& hole = *sensor.hole;
    const HoleWay way = way_through(hole, u_lens, wavelength);
    const Vec3 direction{place.x + way.turn.x, place.y + way.turn.y, Float(1.0f)};
    return {way.point, direction, weight_of(hole, direction.x, direction.y)};
  }
  LocalConnection connect(const SensorRecord& sensor, Vec3 point, Vec2 u_lens) const override {
    return connect_dispersed(sensor, point, u_lens, Float(kMiddleNm));
  }
  LocalConnection connect_dispersed(const SensorRecord& sensor, Vec3 point, Vec2 u_lens,
                                    Float wavelength) const override {
    const HoleTable& hole = *sensor.hole;
    const HoleWay way = way_through(hole, u_lens, wavelength);
    const Float x = (point.x - way.point.x) / point.z, y = (point.y - way.point.y) / point.z;
    LocalConnection seen = through_plane(sensor, point, {x - way.turn.x, y - way.turn.y}, way.point);
    seen.importance = seen.density * weight_of(hole, x, y);
    return seen;
  }
  Float pixel_width(const SensorRecord& sensor, Float distance) const override {
    return distance * pixel_step(sensor);
  }
};

}  // namespace

const ModelOf<HoleSensor> hole(SensorKind::kHole);

}  // namespace tessera::render::TESSERA_ISA
