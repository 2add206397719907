// Six perspectives of 90 degrees [Greene 1986, Environment Mapping and Other Applications of World
// Projections]. Places are halves of cells of the picture, each of which is a face or black.
#include "render/core/constants.h"
#include "render/sensor/model/about_point.h"
#include "render/sensor/panorama_table.h"

namespace tessera::render::TESSERA_ISA {

namespace {

Vec3 axis_of(const float (&v)[3]) { return {Float(v[0]), Float(v[1]), Float(v[2])}; }

/// From places of a row to those of the plane of a face, or the other way.
Float on_face(const CubeRecord& cube, Float place) {
  if (!cube.equiangular) return place;
  const Float angle = place * (kPi / 4);
  return sin(angle) / cos(angle);
}
Float in_row(const CubeRecord& cube, Float on_face) {
  return cube.equiangular ? atan(on_face) * (4 / kPi) : on_face;
}
/// How much a row's place changes for a step on the face.
Float rows_per_step(const CubeRecord& cube, Float on_face) {
  return cube.equiangular ? (4 / kPi) / (1.0f + sqr(on_face)) : Float(1.0f);
}

class CubeMapSensor final : public SensorModel {
 public:
  CubeMapSensor() : SensorModel({.has_axis = false, .may_fail = true}) {}

  LocalRay start(const SensorRecord& sensor, Vec2 place, Vec2) const override {
    const CubeRecord& cube = sensor.panorama->cube;
    // Pixel filters reach beyond the raster, which goes on mirrored there (RasterEdges::kMirrored).
    const auto fold = [](Float x, std::int32_t cells) {
      const auto size = static_cast<float>(cells);
      return size - abs(size - abs(x));
    };
    const Float x = fold(0.5f * place.x, cube.columns), y = fold(0.5f * place.y, cube.rows);
    const Float column = min(floor(x), static_cast<float>(cube.columns - 1)),
                row = min(floor(y), static_cast<float>(cube.rows - 1));
    const Float u = on_face(cube, fma(x - column, Float(2.0f), Float(-1.0f))),
                v = on_face(cube, fma(y - row, Float(-2.0f), Float(1.0f)));
    LocalRay ray{sensor_origin(), {Float(0.0f), Float(0.0f), Float(1.0f)}};
    ray.valid = Mask::none();
    for (std::int32_t i = 0; i < cube.faces; ++i) {
      const CubeFace& face = cube.face[i];
      const Mask here = (column == face.column) & (row == face.row);
      const Vec3 through = fma(axis_of(face.right), u, fma(axis_of(face.up), v, axis_of(face.forward)));
      ray.direction = select(here, through, ray.direction);
      ray.valid |= here;
    }
    return ray;
  }

  LocalConnection connect(const SensorRecord& sensor, Vec3 point, Vec2) const override {
    const CubeRecord& cube = sensor.panorama->cube;
    LocalConnection found = from_point(sensor, point, {Float(0.0f), Float(0.0f)}, Float(1.0f));
    found.valid = Mask::none();
    for (std::int32_t i = 0; i < cube.faces; ++i) {
      const CubeFace& face = cube.face[i];
      const Float depth = dot(point, axis_of(face.forward)), inverse = 1.0f / max(depth, 1e-30f);
      const Float u = dot(point, axis_of(face.right)) * inverse, v = dot(point, axis_of(face.up)) * inverse;
      const Mask here = and_not((depth > 0.0f) & (abs(u) <= 1.0f) & (abs(v) <= 1.0f), found.valid);
      if (none(here)) continue;
      const Vec2 place{2.0f * face.column + 1.0f + in_row(cube, u), 2.0f * face.row + 1.0f - in_row(cube, v)};
      // A steradian takes more of the face the farther from its middle, by the cube of the secant.
      const Float secant = length(point) * inverse;
      const Float places = rows_per_step(cube, u) * rows_per_step(cube, v) * (secant * secant * secant);
      const LocalConnection seen = from_point(sensor, point, place, places);
      found.place = {select(here, seen.place.x, found.place.x), select(here, seen.place.y, found.place.y)};
      found.density = select(here, seen.density, found.density);
      found.valid |= here;
    }
    found.importance = found.density;
    return found;
  }

  Float pixel_width(const SensorRecord& sensor, Float distance) const override {
    return distance * (pixel_step(sensor) * (sensor.panorama->cube.equiangular ? kPi / 4 : 1.0f));
  }
};

}  // namespace

const ModelOf<CubeMapSensor> cube_map(SensorKind::kCubeMap);

}  // namespace tessera::render::TESSERA_ISA
