#include "render/sensor/footprint_record.h"

#include <algorithm>
#include <cmath>

#include "render/sensor/distortion_table.h"

namespace tessera::render {

namespace {

/// Length of a column of the map; the unit vector along it.
double axis_of(const Affine& map, int column, float (&unit)[3]) {
  const double v[3] = {map.m[column], map.m[4 + column], map.m[8 + column]};
  const double length = std::hypot(v[0], v[1], v[2]);
  for (int i = 0; i < 3; ++i) unit[i] = static_cast<float>(v[i] / length);
  return length;
}

/// Distance from the middle of the farthest undistorted place that the sensor sees.
double farthest_place(const SensorRecord& sensor) {
  const auto farthest = [](double first, double size) {
    return std::max(std::abs(first), std::abs(first + size));
  };
  if (sensor.distortion == nullptr) {
    return std::hypot(farthest(sensor.offset_x, double{sensor.scale_x} * sensor.width),
                      farthest(sensor.offset_y, double{sensor.scale_y} * sensor.height));
  }
  const PlaceGrid& seen = sensor.distortion->start_grid;
  return std::hypot(farthest(seen.first_x, seen.columns / double{seen.per_x}),
                    farthest(seen.first_y, seen.rows / double{seen.per_y}));
}

}  // namespace

FootprintRecord footprint_of(const SensorRecord& sensor, double part) {
  FootprintRecord record;
  record.on = part > 0;
  if (!record.on) return record;
  const Affine& pose =
      sensor.steps.empty() ? sensor.render_from_sensor : sensor.steps[sensor.steps.size() / 2];
  const double right = axis_of(pose, 0, record.x), up = axis_of(pose, 1, record.y),
               forward = axis_of(pose, 2, record.z);
  for (int i = 0; i < 3; ++i) record.place[i] = pose.m[4 * i + 3];
  double spread_x = std::abs(double{sensor.scale_x}), spread_y = std::abs(double{sensor.scale_y});
  const RasterTraits raster = raster_of(sensor.kind);
  switch (raster.shape) {
    case RasterShape::kPlane:
      spread_x *= right / forward, spread_y *= up / forward;
      record.least_cosine = static_cast<float>(1 / std::hypot(1.0, farthest_place(sensor)));
      record.units_x = static_cast<float>(right / forward), record.units_y = static_cast<float>(up / forward);
      break;
    case RasterShape::kParallel:
      record.parallel = true;
      spread_x *= right, spread_y *= up;
      record.units_x = static_cast<float>(right), record.units_y = static_cast<float>(up);
      break;
    case RasterShape::kSphere:
      spread_x *= raster.angle_x, spread_y *= raster.angle_y;
      break;
    case RasterShape::kOther:  // nothing is known of its pixels
      return {};
  }
  record.distortion = sensor.distortion.get();
  record.kind = sensor.kind;
  record.spread_x = static_cast<float>(part * spread_x);
  record.spread_y = static_cast<float>(part * spread_y);
  return record;
}

}  // namespace tessera::render
