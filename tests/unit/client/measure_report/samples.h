// A measured room for tests.
#pragma once

#include <cmath>
#include <limits>
#include <string>

#include "measure/measured.h"

namespace tessera::client {

inline Reading reading_at(const Imath::V3d& position, double value, double error, double freedom = 63) {
  return {
      .label = "",
      .position = position,
      .normal = {0, 0, 1},
      .figure = {.value = value, .standard_error = error, .samples = 4096, .degrees_of_freedom = freedom}};
}

inline MeasuredMeter meter_of(const char* name, const char* quantity, const char* unit,
                              const char* algorithm) {
  MeasuredMeter meter;
  meter.name = name, meter.quantity = quantity, meter.unit = unit, meter.algorithm = algorithm;
  return meter;
}

/// A meter with one plane on the floor, 3 x 2 m: values 1 to columns * rows, row by row, with one error.
inline MeasuredMeter floor_of(std::uint32_t columns, std::uint32_t rows, double error = 0.125) {
  MeasuredMeter meter = meter_of("floor", "illuminance", "lx", "path");
  meter.planes.push_back({.corner = {1, 2, 0},
                          .edge_u = {3, 0, 0},
                          .edge_v = {0, 2, 0},
                          .columns = columns,
                          .rows = rows,
                          .first_reading = 0});
  for (std::uint32_t row = 0; row < rows; ++row) {
    for (std::uint32_t column = 0; column < columns; ++column) {
      const double x = 1 + 3 * (column + 0.5) / columns, y = 2 + 2 * (row + 0.5) / rows;
      meter.readings.push_back(reading_at({x, y, 0}, row * columns + column + 1, error));
    }
  }
  return meter;
}

/// A reading that is of no place, and exact.
inline MeasuredMeter exact_flux() {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  MeasuredMeter meter = meter_of("lamp", "flux", "lm", "");
  meter.readings.push_back({.label = "", .position = {kNone, kNone, kNone}, .figure = {.value = 4 * M_PI}});
  return meter;
}

inline Measured room_of(std::vector<MeasuredMeter> meters) {
  Measured measured;
  measured.scene = "room.textproto", measured.meters_file = "meters.textproto";
  measured.metres_per_unit = 1;
  measured.seed = 7;
  measured.meters = std::move(meters);
  return measured;
}

}  // namespace tessera::client
