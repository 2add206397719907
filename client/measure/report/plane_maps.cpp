#include "measure/report/plane_maps.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "image/exr.h"
#include "measure/report/intervals.h"
#include "measure/report/plane_summary.h"

namespace tessera::client {
namespace {

std::string axis_label(const std::string& what, const std::string& unit) {
  return unit.empty() ? what : absl::StrCat(what, " / ", unit);
}

void add_plane(const char* name, const ValueGrid& values, Image& image) {
  Channel& channel = image.add(name);
  std::ranges::transform(values.values, channel.values.begin(),
                         [](double value) { return static_cast<float>(value); });
}

}  // namespace

std::string unit_label(const std::string& unit) {
  return absl::StrReplaceAll(unit, {{"m^2", "m\u00b2"}, {"m2", "m\u00b2"}});
}

FalseColorOptions false_color_of(const Measured& measured, const MeasuredMeter& meter,
                                 const MeasuredPlane& plane, const PlaneMapOptions& options) {
  const PlaneSize size = size_of(plane, measured.metres_per_unit);
  FalseColorOptions look;
  look.title = meter.name;
  look.unit = unit_label(meter.unit);
  look.subtitle = axis_label(meter.quantity, look.unit);
  look.map = options.map, look.scale = options.scale, look.range = options.range;
  look.isolines = options.isolines, look.smooth = options.smooth;
  look.width = size.width, look.height = size.height, look.length_unit = size.unit;
  return look;
}

absl::StatusOr<Image> plane_image(const MeasuredMeter& meter, const MeasuredPlane& plane,
                                  const PlaneMapOptions& options) {
  const absl::StatusOr<ValueGrid> grid = grid_of(meter, plane);
  if (!grid.ok()) return grid.status();
  const std::uint32_t side = std::max<std::uint32_t>(1, options.exr_pixels);
  Image image;
  image.data = image.display = {0, 0, static_cast<std::int32_t>(grid->columns * side),
                                static_cast<std::int32_t>(grid->rows * side)};
  add_plane("Y", enlarged(*grid, side, side, options.smooth), image);
  add_plane("error.Y", enlarged(errors_of(meter, plane), side, side, options.smooth), image);
  image.metadata["tessera.meter"] = meter.name;
  image.metadata["tessera.quantity"] = meter.quantity;
  image.metadata["tessera.unit"] = meter.unit;
  return image;
}

absl::Status write_plane_map(const Measured& measured, const MeasuredMeter& meter, const MeasuredPlane& plane,
                             const PlaneMapOptions& options, const std::string& path) {
  if (absl::EndsWithIgnoreCase(path, ".exr")) {
    const absl::StatusOr<Image> image = plane_image(meter, plane, options);
    return image.ok() ? write_exr(*image, path) : image.status();
  }
  const absl::StatusOr<ValueGrid> grid = grid_of(meter, plane);
  if (!grid.ok()) return grid.status();
  return write_false_color(*grid, false_color_of(measured, meter, plane, options), path);
}

AxesPlot plane_histogram(const MeasuredMeter& meter, const ValueGrid& grid, const PlaneMapOptions& options) {
  AxesPlot plot =
      histogram_of(grid.values, scale_over(grid.values, options.scale, options.range), options.map);
  plot.title = "Histogram";
  plot.x_label = axis_label(meter.quantity, unit_label(meter.unit));
  return plot;
}

AxesPlot plane_section(const Measured& measured, const MeasuredMeter& meter, const MeasuredPlane& plane,
                       const PlaneLine& line) {
  const PlaneSize size = size_of(plane, measured.metres_per_unit);
  AxesPlot plot;
  plot.title = "Section";
  plot.x_label = axis_label("distance", size.unit);
  plot.y_label = axis_label(meter.quantity, unit_label(meter.unit));
  if (!grid_of(meter, plane).ok()) return plot;
  const double along_u = line.u1 - line.u0, along_v = line.v1 - line.v0;
  const Imath::V3d way = plane.edge_u * along_u + plane.edge_v * along_v;
  const double scale = measured.metres_per_unit > 0 ? measured.metres_per_unit : 1;
  const double steps = std::max(
      1.0, std::ceil(std::max(std::abs(along_u) * plane.columns, std::abs(along_v) * plane.rows) - 1e-9));
  const auto cell_at = [](double share, std::uint32_t count) {
    return static_cast<std::size_t>(std::clamp(share * count, 0.0, count - 1.0));
  };
  if (way.length() > 0) plot.x_range = {0, way.length() * scale};
  Intervals intervals;
  std::size_t before = meter.readings.size();
  for (double i = 0; i < steps; ++i) {
    const double share = (i + 0.5) / steps;
    const std::size_t cell = cell_at(line.v0 + share * along_v, plane.rows) * plane.columns +
                             cell_at(line.u0 + share * along_u, plane.columns);
    if (cell == std::exchange(before, cell)) continue;
    const Figure& figure = meter.readings[plane.first_reading + cell].figure;
    const ConfidenceInterval interval = intervals.of(figure);
    plot.points.push_back({share * way.length() * scale, figure.value, interval.low, interval.high});
  }
  return plot;
}

}  // namespace tessera::client
