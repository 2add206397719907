#include "measure/report/measured_html.h"

#include <cmath>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "measure/report/html_style.h"
#include "measure/report/intervals.h"
#include "measure/report/mesh_maps.h"
#include "measure/report/plan_drawing.h"
#include "measure/report/plane_summary.h"
#include "measure/report/series_chart.h"

namespace tessera::client {
namespace {

constexpr std::size_t kFewWarnings = 8;
constexpr double kPlanWidth = 760;
/// Readings of a meter that the table shows at once; more are behind a line that opens them.
constexpr std::size_t kMostRows = 24;
/// Diagrams of a meter over a series; figures of more places are in the steps' tables.
constexpr std::size_t kMostCharts = 12;

std::string element(const char* tag, const std::string& content) {
  return absl::StrCat("<", tag, ">", content, "</", tag, ">");
}

std::string percent(double share) { return absl::StrFormat("%.2g %%", 100 * share); }

std::string plus_minus(const Figure& figure) {
  const FigureText text = figure_text(figure.value, figure.standard_error);
  return text.error.empty() ? text.value : absl::StrCat(text.value, " \u00b1 ", text.error);
}

std::string unit_markup(const MeasuredMeter& meter) { return markup_escaped(unit_label(meter.unit)); }

std::string interval_text(const Figure& figure, Intervals& intervals) {
  if (is_exact(figure)) return "exact";
  const ConfidenceInterval interval = intervals.of(figure);
  return absl::StrCat(figure_text(interval.low, figure.standard_error).value, " to ",
                      figure_text(interval.high, figure.standard_error).value);
}

/// Name and value, where there is a value.
void append_fact(const char* name, const std::string& value, std::string& html) {
  if (!value.empty()) absl::StrAppend(&html, "<div><dt>", name, "</dt><dd>", value, "</dd></div>");
}

class Report {
 public:
  Report(const Measured& measured, const MeasuredReportOptions& options)
      : measured_(measured), options_(options) {}

  std::string html() { return page_of(absl::StrCat(warnings(), plan(), content())); }

  /// A page about what was measured, with something else in it.
  std::string page_of(const std::string& body) const {
    std::string page = "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"/>";
    absl::StrAppend(&page, "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>",
                    "<meta name=\"color-scheme\" content=\"light dark\"/>",
                    "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src "
                    "'unsafe-inline'; img-src data:\"/>",
                    element("title", markup_escaped(options_.title)), element("style", kReportStyle),
                    "</head><body>\n");
    absl::StrAppend(&page, "<header>", element("h1", markup_escaped(options_.title)), facts(),
                    "</header>\n<main>\n");
    absl::StrAppend(&page, body, method(), "</main>\n</body></html>\n");
    return page;
  }

  /// Maps and the table.
  std::string content() {
    std::string sections;
    for (const MeasuredMeter& meter : measured_.meters) {
      for (const MeasuredPlane& plane : meter.planes)
        absl::StrAppend(&sections, plane_section_of(meter, plane));
      for (const MeasuredMesh& mesh : meter.meshes) absl::StrAppend(&sections, mesh_section_of(meter, mesh));
    }
    return sections + table();
  }

  std::string charts_over(const MeasuredSeries& series) const {
    std::string diagrams;
    for (std::size_t m = 0; m < measured_.meters.size(); ++m) {
      for (const SeriesChart& chart : charts_of(series, m, kMostCharts))
        absl::StrAppend(&diagrams, diagram(chart.plot, absl::StrCat(chart.label, " over the series")));
    }
    return absl::StrCat("<section><h2>Over the series</h2><div class=\"diagrams\">", diagrams,
                        "</div></section>\n");
  }

  std::string facts() const {
    std::string list = "<dl class=\"facts\">";
    append_fact("Scene", markup_escaped(measured_.scene), list);
    append_fact("Meters", markup_escaped(measured_.meters_file), list);
    append_fact("Unit of length",
                measured_.metres_per_unit > 0 ? absl::StrCat(short_text(measured_.metres_per_unit), " m")
                                              : std::string("not said"),
                list);
    if (measured_.wanted_error > 0)
      append_fact("Error asked for", absl::StrCat("\u00b1 ", percent(measured_.wanted_error), " (95 %)"),
                  list);
    if (!measured_.worst_meter.empty()) {
      append_fact("Worst error reached",
                  absl::StrCat("\u00b1 ", percent(measured_.worst_error), ", ",
                               markup_escaped(measured_.worst_meter)),
                  list);
    }
    append_fact("Seed", absl::StrCat(measured_.seed), list);
    if (measured_.cpu_seconds > 0)
      append_fact("CPU time", absl::StrFormat("%.3g s", measured_.cpu_seconds), list);
    return list + "</dl>";
  }

  std::string warnings() const {
    std::string items;
    std::size_t count = 0;
    for (const MeasuredMeter& meter : measured_.meters) {
      count += meter.warnings.size();
      for (const std::string& warning : meter.warnings) {
        absl::StrAppend(&items, element("li", absl::StrCat(element("b", markup_escaped(meter.name)), ": ",
                                                           markup_escaped(warning))));
      }
    }
    if (count == 0) return "";
    // Many, such as those of all steps of a series, would hide the figures.
    if (count > kFewWarnings)
      return absl::StrCat("<details class=\"warnings\"><summary>", count, " warnings</summary><ul>", items,
                          "</ul></details>\n");
    return absl::StrCat("<section class=\"warnings\"><h2>Warnings</h2><ul>", items, "</ul></section>\n");
  }

  std::string plan() const {
    const PlanDrawing drawing(measured_, options_, kPlanWidth);
    if (!drawing.has_places()) return "";
    const std::string svg =
        svg_element(kPlanWidth, drawing.height(), "Plan: places of all meters, from above",
                    [&](Canvas& canvas) { drawing.draw(canvas); });
    return absl::StrCat("<section><h2>Plan</h2><figure>", svg,
                        "<figcaption>Seen from above, in the scene's units. Numbers are those of the table",
                        options_.has_bounds ? "; the dashed line is the scene's bounds" : "",
                        ".</figcaption></figure></section>\n");
  }

 private:
  std::string plane_section_of(const MeasuredMeter& meter, const MeasuredPlane& plane) {
    const absl::StatusOr<ValueGrid> grid = grid_of(meter, plane);
    if (!grid.ok()) return element("p", markup_escaped(std::string(grid.status().message())));
    const PlaneSummary summary = summary_of(meter, plane);
    const std::string map =
        map_of(meter, *grid, false_color_of(measured_, meter, plane, options_.maps), summary);
    std::string diagrams =
        diagram(plane_histogram(meter, *grid, options_.maps), "Histogram of " + meter.name);
    if (plane.columns > 1)
      absl::StrAppend(&diagrams,
                      section_diagram(meter, plane, {0, 0.5, 1, 0.5}, "Section along u, at half of v"));
    if (plane.rows > 1)
      absl::StrAppend(&diagrams,
                      section_diagram(meter, plane, {0.5, 0, 0.5, 1}, "Section along v, at half of u"));
    return absl::StrCat(heading(meter),
                        facts_of(meter, summary, absl::StrFormat("%u \u00d7 %u", plane.columns, plane.rows)),
                        map, "<div class=\"diagrams\">", diagrams, "</div></section>\n");
  }

  std::string mesh_section_of(const MeasuredMeter& meter, const MeasuredMesh& mesh) const {
    const absl::StatusOr<MeshView> view =
        view_of(meter, mesh, {.maps = options_.maps, .y_up = options_.y_up});
    if (!view.ok()) return element("p", markup_escaped(std::string(view.status().message())));
    const PlaneSummary summary = summary_of(meter, mesh);
    return absl::StrCat(
        heading(meter),
        facts_of(meter, summary,
                 absl::StrCat(mesh.triangles.size(), " triangles of ", markup_escaped(mesh.shape))),
        map_of(meter, view->values, false_color_of(meter, mesh, options_.maps), summary), "</section>\n");
  }

  static std::string heading(const MeasuredMeter& meter) {
    return absl::StrCat(
        "<section class=\"plane\">",
        element("h2", absl::StrCat(markup_escaped(meter.name), ": ", markup_escaped(meter.quantity))));
  }

  static std::string map_of(const MeasuredMeter& meter, const ValueGrid& grid, FalseColorOptions look,
                            const PlaneSummary& summary) {
    look.title = look.subtitle = "";  // the page says it
    const FalseColorLayout layout = false_color_layout(grid, look);
    const std::string map =
        svg_element(layout.page_width, layout.page_height,
                    absl::StrCat("False-colour map of ", meter.quantity, ", ", meter.name, ": ",
                                 extreme_text(summary, summary.least), " to ",
                                 extreme_text(summary, summary.most), " ", unit_label(meter.unit)),
                    [&](Canvas& canvas) { draw_false_color(canvas, grid, look); });
    return absl::StrCat("<figure class=\"map\">", map, "</figure>");
  }

  static std::string facts_of(const MeasuredMeter& meter, const PlaneSummary& summary,
                              const std::string& cells) {
    const std::string unit = unit_markup(meter);
    std::string list = "<dl class=\"facts\">";
    append_fact("Mean", absl::StrCat(plus_minus(summary.mean), " ", unit), list);
    append_fact("Least", absl::StrCat(extreme_text(summary, summary.least), " ", unit), list);
    append_fact("Largest", absl::StrCat(extreme_text(summary, summary.most), " ", unit), list);
    append_fact("U<sub>0</sub>, least / mean", absl::StrFormat("%.3f", summary.uniformity_mean), list);
    append_fact("U<sub>1</sub>, least / largest", absl::StrFormat("%.3f", summary.uniformity_most), list);
    append_fact("Cells", cells, list);
    if (summary.missing > 0) append_fact("Without a value", absl::StrCat(summary.missing), list);
    if (summary.worst_error > 0)
      append_fact("Worst cell, standard error", percent(summary.worst_error), list);
    return list + "</dl>";
  }

  std::string section_diagram(const MeasuredMeter& meter, const MeasuredPlane& plane, const PlaneLine& line,
                              const std::string& title) {
    AxesPlot plot = plane_section(measured_, meter, plane, line);
    plot.title = title;
    return diagram(plot, absl::StrCat(title, ", ", meter.name));
  }

  std::string diagram(const AxesPlot& plot, const std::string& label) const {
    return element("figure", svg_element(kAxesPlotWidth, kAxesPlotHeight, label,
                                         [&](Canvas& canvas) { draw_axes_plot(canvas, plot); }));
  }

  std::string row(std::size_t number, const MeasuredMeter& meter, const std::string& place,
                  const Figure& figure) {
    std::string cells = absl::StrCat("<td>", number, "</td>", element("td", markup_escaped(meter.name)),
                                     element("td", markup_escaped(place)), "<td class=\"number\">",
                                     plus_minus(figure), "</td>");
    absl::StrAppend(&cells, element("td", unit_markup(meter)), "<td class=\"number\">",
                    interval_text(figure, intervals_), "</td><td class=\"number\">", figure.samples, "</td>",
                    element("td", meter.algorithm.empty() ? "closed form" : markup_escaped(meter.algorithm)));
    return element("tr", cells);
  }

  static std::string place_of(const Reading& reading) {
    std::string place = reading.label;
    const Imath::V3d& at = reading.position;
    if (std::isfinite(at.x)) {
      absl::StrAppend(&place, place.empty() ? "" : " ", "(", short_text(at.x), ", ", short_text(at.y), ", ",
                      short_text(at.z), ")");
    }
    return place;
  }

  static std::string table_of(const std::string& rows) {
    return absl::StrCat(
        "<div class=\"wide\"><table><thead><tr><th>No.</th><th>meter</th><th>place</th>"
        "<th class=\"number\">value \u00b1 standard error</th><th>unit</th>"
        "<th class=\"number\">95 % interval</th><th "
        "class=\"number\">samples</th><th>integrator</th></tr></thead>"
        "<tbody>",
        rows, "</tbody></table></div>");
  }

  std::string table() {
    std::string rows, further;
    for (std::size_t i = 0; i < measured_.meters.size(); ++i) {
      const MeasuredMeter& meter = measured_.meters[i];
      for (const MeasuredPlane& plane : meter.planes)
        absl::StrAppend(
            &rows, row(i + 1, meter, absl::StrFormat("mean of %u \u00d7 %u cells", plane.columns, plane.rows),
                       summary_of(meter, plane).mean));
      for (const MeasuredMesh& mesh : meter.meshes)
        absl::StrAppend(
            &rows,
            row(i + 1, meter, absl::StrCat("mean of ", mesh.triangles.size(), " triangles of ", mesh.shape),
                summary_of(meter, mesh).mean));
      std::vector<std::string> places;
      for (std::size_t r = 0; r < meter.readings.size(); ++r) {
        if (!is_of_map(meter, r))
          places.push_back(row(i + 1, meter, place_of(meter.readings[r]), meter.readings[r].figure));
      }
      const bool many = places.size() > kMostRows;
      std::string& into = many ? further : rows;
      std::string all;
      for (const std::string& place : places) absl::StrAppend(&all, place);
      if (many) {
        absl::StrAppend(&into, "<details><summary>", places.size(), " figures of ",
                        markup_escaped(meter.name), " (no. ", i + 1, ")</summary>", table_of(all),
                        "</details>");
      } else {
        absl::StrAppend(&into, all);
      }
    }
    return absl::StrCat("<section><h2>Figures</h2>", rows.empty() ? "" : table_of(rows), further,
                        "</section>\n");
  }

  std::string method() const {
    return absl::StrCat(
        "<section><h2>Method</h2><ul>",
        "<li>Each figure is the mean of independent estimates by the integrator that its line names, all of "
        "them without bias.</li>",
        "<li>\u00b1 is the standard error of that mean. A 95 % interval is this error times the quantile of "
        "Student's t distribution for the number of estimates.</li>",
        "<li>The error of a mean over a plane or a surface is that of independent cells, weighed by their "
        "areas. Its least and largest value are those "
        "of the cells as measured: noise moves them apart.</li>",
        "<li>The same scene, meters, seed and number of samples give the same figures on any farm.</li>",
        "</ul></section>\n");
  }

  const Measured& measured_;
  const MeasuredReportOptions& options_;
  Intervals intervals_;
};

/// Tells of all steps: the worst error, all time, and warnings with their steps.
Measured overview_of(const MeasuredSeries& series) {
  Measured whole;
  if (series.steps.empty()) return whole;
  whole = series.steps.front().measured;
  whole.cpu_seconds = 0;
  whole.meters.clear();
  for (const MeasuredStep& step : series.steps) {
    const std::string label = absl::StrCat(series.name, " ", step_text(step));
    whole.cpu_seconds += step.measured.cpu_seconds;
    if (step.measured.worst_error > whole.worst_error) {
      whole.worst_error = step.measured.worst_error;
      whole.worst_meter = absl::StrCat(step.measured.worst_meter, ", ", label);
    }
    for (const MeasuredMeter& meter : step.measured.meters) {
      if (meter.warnings.empty()) continue;
      MeasuredMeter& warned = whole.meters.emplace_back();
      warned.name = absl::StrCat(meter.name, ", ", label), warned.warnings = meter.warnings;
    }
  }
  return whole;
}

}  // namespace

std::string measured_html(const Measured& measured, const MeasuredReportOptions& options) {
  return Report(measured, options).html();
}

std::string measured_html(const MeasuredSeries& series, const MeasuredReportOptions& options) {
  const Measured overview = overview_of(series);
  const Report whole(overview, options);
  std::string body = whole.warnings();
  for (const MeasuredStep& step : series.steps) {
    Report report(step.measured, options);
    if (&step == &series.steps.front()) absl::StrAppend(&body, report.plan(), report.charts_over(series));
    absl::StrAppend(&body, "<details><summary>", markup_escaped(series.name), " ",
                    markup_escaped(step_text(step)), ": ", markup_escaped(step.sky), "</summary>",
                    report.content(), "</details>\n");
  }
  return whole.page_of(body);
}

}  // namespace tessera::client
