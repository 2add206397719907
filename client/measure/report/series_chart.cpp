#include "measure/report/series_chart.h"

#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "measure/report/intervals.h"
#include "measure/report/plane_maps.h"
#include "measure/report/plane_summary.h"

namespace tessera::client {

std::vector<SeriesChart> charts_of(const MeasuredSeries& series, std::size_t meter, std::size_t most) {
  std::vector<SeriesChart> charts;
  if (series.steps.empty()) return charts;
  Intervals intervals;
  const auto add = [&](const std::string& place,
                       const std::function<Figure(const MeasuredMeter&)>& figure_of) {
    if (charts.size() >= most) return;
    const MeasuredMeter& first = series.steps.front().measured.meters[meter];
    SeriesChart& chart = charts.emplace_back();
    chart.label = absl::StrCat(first.name, place.empty() ? "" : ": ", place);
    chart.plot.title = chart.label;
    chart.plot.x_label = series.name == "cie_type" ? "CIE type" : series.name;
    chart.plot.y_label = absl::StrCat(first.quantity, ", ", unit_label(first.unit));
    for (const MeasuredStep& step : series.steps) {
      const Figure figure = figure_of(step.measured.meters[meter]);
      const ConfidenceInterval interval = intervals.of(figure);
      constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
      // Glare has no end where it is dark.
      const bool there = std::isfinite(figure.value) && std::isfinite(interval.high);
      chart.plot.points.push_back(
          {.x = step.value, .y = there ? figure.value : kNone, .low = interval.low, .high = interval.high});
    }
  };
  const MeasuredMeter& first = series.steps.front().measured.meters[meter];
  for (std::size_t p = 0; p < first.planes.size(); ++p) {
    const MeasuredPlane& plane = first.planes[p];
    add(absl::StrCat("mean of ", plane.columns, " x ", plane.rows, " cells"),
        [p](const MeasuredMeter& now) { return summary_of(now, now.planes[p]).mean; });
  }
  for (std::size_t p = 0; p < first.meshes.size(); ++p)
    add(absl::StrCat("mean of ", first.meshes[p].triangles.size(), " triangles of ", first.meshes[p].shape),
        [p](const MeasuredMeter& now) { return summary_of(now, now.meshes[p]).mean; });
  for (std::size_t r = 0; r < first.readings.size(); ++r) {
    if (!is_of_map(first, r))
      add(first.readings.size() > 1 ? first.readings[r].label : "",
          [r](const MeasuredMeter& now) { return now.readings[r].figure; });
  }
  return charts;
}

}  // namespace tessera::client
