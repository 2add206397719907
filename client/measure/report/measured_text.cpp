#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "base/printable.h"
#include "measure/report/intervals.h"
#include "measure/report/measured_table.h"
#include "measure/report/plane_summary.h"

namespace tessera::client {
namespace {

enum TextColumn {
  kStep,
  kMeter,
  kPlace,
  kValue,
  kUnit,
  kError,
  kInterval,
  kSamples,
  kIntegrator,
  kColumnCount
};
using TextRow = std::array<std::string, kColumnCount>;

bool is_number(int column) { return column == kValue || column == kError || column == kSamples; }

std::size_t width_of(const std::string& text) {
  return static_cast<std::size_t>(std::ranges::count_if(text, [](char c) { return (c & 0xc0) != 0x80; }));
}

/// Rows in columns that are as wide as they need.
std::string in_columns(const std::vector<TextRow>& rows) {
  std::array<std::size_t, kColumnCount> widths{};
  for (const TextRow& row : rows) {
    for (std::size_t c = 0; c < kColumnCount; ++c) widths[c] = std::max(widths[c], width_of(row[c]));
  }
  std::string text;
  for (const TextRow& row : rows) {
    std::string line;
    for (std::size_t c = 0; c < kColumnCount; ++c) {
      if (widths[c] == 0) continue;
      const std::string space(widths[c] - width_of(row[c]), ' ');
      const bool right = is_number(static_cast<int>(c));
      absl::StrAppend(&line, line.empty() ? "" : "  ", right ? space : "", row[c], right ? "" : space);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    absl::StrAppend(&text, line, "\n");
  }
  return text;
}

std::string place_text(const Reading& reading) {
  std::string place = base::printable(reading.label);
  const Imath::V3d& at = reading.position;
  if (!std::isfinite(at.x)) return place;
  absl::StrAppend(&place, place.empty() ? "" : " ", "(", short_text(at.x), ", ", short_text(at.y), ", ",
                  short_text(at.z), ")");
  return place;
}

TextRow row_of_figure(const std::string& step, const MeasuredMeter& meter, std::string place,
                      const Figure& figure, Intervals& intervals) {
  const FigureText text = figure_text(figure.value, figure.standard_error);
  TextRow row;
  row[kStep] = step;
  row[kMeter] = base::printable(meter.name);
  row[kPlace] = std::move(place);
  row[kValue] = text.value;
  row[kUnit] = meter.unit;
  if (is_exact(figure)) {
    row[kError] = "exact";
  } else {
    row[kError] = text.error.empty() ? "" : absl::StrCat("+- ", text.error);
    const ConfidenceInterval interval = intervals.of(figure);
    row[kInterval] = absl::StrCat(figure_text(interval.low, figure.standard_error).value, " to ",
                                  figure_text(interval.high, figure.standard_error).value);
  }
  row[kSamples] = absl::StrCat(figure.samples);
  row[kIntegrator] = meter.algorithm;
  return row;
}

std::string text_of(const PlaneSummary& summary) {
  std::string text =
      absl::StrFormat("min %s, max %s, U0 %.3f, U1 %.3f", extreme_text(summary, summary.least),
                      extreme_text(summary, summary.most), summary.uniformity_mean, summary.uniformity_most);
  if (summary.missing > 0) absl::StrAppend(&text, ", ", summary.missing, " without a value");
  return text;
}

void append_meter(const std::string& step, const MeasuredMeter& meter, const MeasuredTextOptions& options,
                  Intervals& intervals, std::vector<TextRow>& rows) {
  const auto add = [&](const std::string& cells, const PlaneSummary& summary) {
    rows.push_back(row_of_figure(step, meter, absl::StrCat("mean of ", cells, ": ", text_of(summary)),
                                 summary.mean, intervals));
  };
  for (const MeasuredPlane& plane : meter.planes)
    add(absl::StrFormat("%u x %u cells", plane.columns, plane.rows), summary_of(meter, plane));
  for (const MeasuredMesh& mesh : meter.meshes)
    add(absl::StrCat(mesh.triangles.size(), " triangles of ", base::printable(mesh.shape)),
        summary_of(meter, mesh));
  for (std::size_t i = 0; i < meter.readings.size(); ++i) {
    if (!options.all_cells && is_of_map(meter, i)) continue;
    rows.push_back(
        row_of_figure(step, meter, place_text(meter.readings[i]), meter.readings[i].figure, intervals));
  }
}

TextRow heading_row(const std::string& step) {
  return {step,      "meter",     "place", "value", "unit", "+- standard error", "95 % interval",
          "samples", "integrator"};
}

/// Warnings, and the error that was asked for and reached; `step` before each.
void append_remarks(const std::string& step, const Measured& measured, std::string& text) {
  for (const MeasuredMeter& meter : measured.meters) {
    for (const std::string& warning : meter.warnings) {
      absl::StrAppend(&text, step, "warning: meter '", base::printable(meter.name),
                      "': ", base::printable(warning), "\n");
    }
  }
  if (measured.worst_meter.empty()) return;
  absl::StrAppend(&text, step,
                  absl::StrFormat("worst 95 %% interval: +- %.2g %% of meter '%s'",
                                  100 * measured.worst_error, base::printable(measured.worst_meter)));
  if (measured.wanted_error > 0)
    absl::StrAppend(&text, absl::StrFormat(", +- %.2g %% asked for", 100 * measured.wanted_error));
  text += "\n";
}

}  // namespace

std::string measured_text(const Measured& measured, const MeasuredTextOptions& options) {
  std::vector<TextRow> rows{heading_row("")};
  Intervals intervals;
  for (const MeasuredMeter& meter : measured.meters) append_meter("", meter, options, intervals, rows);
  std::string text = in_columns(rows);
  append_remarks("", measured, text);
  return text;
}

std::string measured_text(const MeasuredSeries& series, const MeasuredTextOptions& options) {
  std::vector<TextRow> rows{heading_row(series.name)};
  Intervals intervals;
  std::string remarks;
  for (const MeasuredStep& step : series.steps) {
    const std::string label = step_text(step);
    for (const MeasuredMeter& meter : step.measured.meters)
      append_meter(label, meter, options, intervals, rows);
    append_remarks(absl::StrCat(series.name, " ", label, ": "), step.measured, remarks);
  }
  return in_columns(rows) + remarks;
}

}  // namespace tessera::client
