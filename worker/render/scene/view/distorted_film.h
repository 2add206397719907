// A film whose places are distorted, in the places of its sensor, and the grids of tables over it.
#pragma once

#include <algorithm>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "render/scene/view/distortion_model.h"
#include "render/sensor/distortion_table.h"
#include "render/sensor/sensor_record.h"

namespace tessera::render {

/// How far tables go beyond the film, pixels.
inline constexpr double kPixelsBeyondFilm = 8;

/// The film in places of the sensor.
struct FilmPlaces {
  double scale_x, scale_y, offset_x, offset_y, width, height;

  explicit FilmPlaces(const SensorRecord& sensor)
      : scale_x(sensor.scale_x),
        scale_y(sensor.scale_y),
        offset_x(sensor.offset_x),
        offset_y(sensor.offset_y),
        width(sensor.width),
        height(sensor.height) {}

  PlanePoint at_pixel(double x, double y) const { return {offset_x + x * scale_x, offset_y + y * scale_y}; }
  PlanePoint pixel_of(PlanePoint place) const {
    return {(place.x - offset_x) / scale_x, (place.y - offset_y) / scale_y};
  }
  bool has(PlanePoint place) const {
    constexpr double kSlack = 1e-6;
    const PlanePoint pixel = pixel_of(place);
    return pixel.x >= -kSlack && pixel.x <= width + kSlack && pixel.y >= -kSlack &&
           pixel.y <= height + kSlack;
  }
  PlanePoint nearest(PlanePoint place) const {
    const PlanePoint pixel = pixel_of(place);
    return at_pixel(std::clamp(pixel.x, 0.0, width), std::clamp(pixel.y, 0.0, height));
  }
};

/// The error of a distortion whose places see what others see; `more`: advice.
absl::Status folds_at(const FilmPlaces& film, PlanePoint place, const std::string& more = "");

/// Lays the grid's cells over pixels of the film, which may begin beyond it.
void span(const FilmPlaces& film, PlanePoint first_pixel, PlanePoint last_pixel, PlaceGrid& grid);

/// The place of a node, as the kernels have it.
PlanePoint node_place(const PlaceGrid& grid, double column, double row);

/// A smooth table, without starts, that is right to a hundred-thousandth of a pixel if 512 cells are enough.
absl::StatusOr<DistortionTable> table_of_model(const DistortionModel& model, const FilmPlaces& film);

/// The undistorted place that a place of the film sees, with its slopes; beyond the table, that of the next
/// one on it.
PlaceAndSlopes seen_on_film(const DistortionTable& table, PlanePoint film);
inline PlanePoint undistorted(const DistortionTable& table, PlanePoint film) {
  return seen_on_film(table, film).place;
}

/// Adds the places from which the search for the inverse starts, and the slopes of footprints.
/// InvalidArgument where the table leads to places that are not finite, or all to one.
absl::Status add_starts(DistortionTable& table);

/// Adds the slopes to a table that has starts.
void add_slopes(DistortionTable& table);

}  // namespace tessera::render
