#include "measure/report/plane_summary.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "absl/strings/str_cat.h"
#include "measure/report/figure_text.h"

namespace tessera::client {
namespace {

std::size_t cells_of(const MeasuredPlane& plane) { return std::size_t{plane.columns} * plane.rows; }

bool is_within(const MeasuredMeter& meter, const MeasuredPlane& plane) {
  return plane.first_reading <= meter.readings.size() &&
         cells_of(plane) <= meter.readings.size() - plane.first_reading;
}

template <class Value>
ValueGrid grid_from(const MeasuredMeter& meter, const MeasuredPlane& plane, Value&& value) {
  ValueGrid grid{plane.columns, plane.rows, {}};
  if (!is_within(meter, plane)) return {};
  // Pages have their first row on top, planes at the corner that they begin with.
  for (std::size_t row = plane.rows; row-- > 0;) {
    for (std::size_t column = 0; column < plane.columns; ++column)
      grid.values.push_back(value(meter.readings[plane.first_reading + row * plane.columns + column].figure));
  }
  return grid;
}

}  // namespace

absl::StatusOr<ValueGrid> grid_of(const MeasuredMeter& meter, const MeasuredPlane& plane) {
  if (plane.columns == 0 || plane.rows == 0 || !is_within(meter, plane)) {
    return absl::InvalidArgumentError(absl::StrCat("meter '", meter.name, "' has ", meter.readings.size(),
                                                   " readings, too few for a plane of ", plane.columns, " x ",
                                                   plane.rows, " from the ", plane.first_reading, "th on"));
  }
  return grid_from(meter, plane, [](const Figure& figure) { return figure.value; });
}

ValueGrid errors_of(const MeasuredMeter& meter, const MeasuredPlane& plane) {
  return grid_from(meter, plane, [](const Figure& figure) { return figure.standard_error; });
}

namespace {

/// Sums up so many readings from `first` on, weighed by `area(i)`.
template <class Area>
PlaneSummary summary_from(const MeasuredMeter& meter, std::size_t first, std::size_t count, Area&& area) {
  PlaneSummary summary;
  double weights = 0, sum = 0, variance = 0, fourth = 0;
  bool exact = true;
  summary.least = std::numeric_limits<double>::infinity(), summary.most = -summary.least;
  for (std::size_t i = 0; i < count; ++i) {
    const Figure& figure = meter.readings[first + i].figure;
    summary.mean.samples += figure.samples;
    if (!std::isfinite(figure.value)) {
      ++summary.missing;
      continue;
    }
    ++summary.cells;
    const double weight = area(i);
    weights += weight;
    sum += weight * figure.value;
    summary.least = std::min(summary.least, figure.value);
    summary.most = std::max(summary.most, figure.value);
    const double error = weight * figure.standard_error, square = error * error;
    variance += square;
    if (figure.degrees_of_freedom > 0) fourth += square * square / figure.degrees_of_freedom;
    exact = exact && is_exact(figure);
    if (figure.value != 0)
      summary.worst_error = std::max(summary.worst_error, figure.standard_error / std::abs(figure.value));
  }
  if (summary.cells == 0) {
    summary.mean.value = summary.least = summary.most = std::numeric_limits<double>::quiet_NaN();
    return summary;
  }
  summary.mean.value = sum / weights;
  summary.mean.standard_error = std::sqrt(variance) / weights;
  if (!exact && fourth > 0) summary.mean.degrees_of_freedom = variance * variance / fourth;
  if (summary.mean.value != 0) summary.uniformity_mean = summary.least / summary.mean.value;
  if (summary.most != 0) summary.uniformity_most = summary.least / summary.most;
  return summary;
}

}  // namespace

PlaneSummary summary_of(const MeasuredMeter& meter, const MeasuredPlane& plane) {
  if (!is_within(meter, plane)) return {};
  return summary_from(meter, plane.first_reading, cells_of(plane), [](std::size_t) { return 1.0; });
}

PlaneSummary summary_of(const MeasuredMeter& meter, const MeasuredMesh& mesh) {
  if (!is_within(meter, mesh)) return {};
  return summary_from(meter, mesh.first_reading, mesh.triangles.size(), [&](std::size_t t) {
    const auto& [a, b, c] = mesh.triangles[t];
    return ((mesh.vertices[b] - mesh.vertices[a]) % (mesh.vertices[c] - mesh.vertices[a])).length() / 2;
  });
}

bool is_within(const MeasuredMeter& meter, const MeasuredMesh& mesh) {
  return mesh.first_reading <= meter.readings.size() &&
         mesh.triangles.size() <= meter.readings.size() - mesh.first_reading;
}

std::string extreme_text(const PlaneSummary& summary, double value) {
  return figure_text(value, std::abs(value) * summary.worst_error).value;
}

PlaneSize size_of(const MeasuredPlane& plane, double metres_per_unit) {
  const double scale = metres_per_unit > 0 ? metres_per_unit : 1;
  return {plane.edge_u.length() * scale, plane.edge_v.length() * scale, metres_per_unit > 0 ? "m" : "units"};
}

bool is_of_map(const MeasuredMeter& meter, std::size_t reading) {
  const auto is_of = [&](const auto& part, std::size_t cells) {
    return is_within(meter, part) && reading >= part.first_reading && reading - part.first_reading < cells;
  };
  return std::ranges::any_of(meter.planes,
                             [&](const auto& plane) { return is_of(plane, cells_of(plane)); }) ||
         std::ranges::any_of(meter.meshes,
                             [&](const auto& mesh) { return is_of(mesh, mesh.triangles.size()); });
}

}  // namespace tessera::client
