#include "plot/log_log_plot.h"

#include <cairo.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "plot/plot_file.h"

namespace tessera::client {
namespace {

constexpr double kWidth = 1200, kHeight = 750;
constexpr double kPlotLeft = 120, kPlotTop = 110, kPlotBottom = kHeight - 90, kLegendWidth = 330;

struct Color {
  double r, g, b;
};
constexpr Color kInk{0.13, 0.15, 0.18}, kFaint{0.45, 0.48, 0.52}, kGrid{0.86, 0.88, 0.9},
    kFineGrid{0.94, 0.95, 0.96};
// Told apart by all eyes [Okabe & Ito 2008].
constexpr std::array<Color, 8> kColors{{{0.0, 0.447, 0.698},
                                        {0.835, 0.369, 0.0},
                                        {0.0, 0.62, 0.451},
                                        {0.8, 0.475, 0.655},
                                        {0.902, 0.624, 0.0},
                                        {0.337, 0.706, 0.914},
                                        {0.35, 0.35, 0.35},
                                        {0.72, 0.66, 0.0}}};
enum class Align { kLeft, kMiddle, kRight };

bool can_draw(const PlotPoint& p) { return std::isfinite(p.x) && std::isfinite(p.y) && p.x > 0 && p.y > 0; }
/// Bars end there, however long they are: two seeds can have intervals of many decades.
constexpr double kLongestBar = 10;
double bar_low(const PlotPoint& p) { return std::max(p.low, p.y / kLongestBar); }
double bar_high(const PlotPoint& p) { return std::min(p.high, p.y * kLongestBar); }
bool has_bar(const PlotPoint& p) { return std::isfinite(p.high) && p.low > 0 && p.high > p.low; }

/// Values from 10^first to 10^last lie between `begin` and `end` on the page.
struct Axis {
  double first = 0, last = 1;
  double begin = 0, end = 1;

  double place(double value) const {
    return begin + (std::log10(value) - first) / (last - first) * (end - begin);
  }

  /// With some air around, and not less than half a decade.
  void fit(double low, double high) {
    first = std::log10(low), last = std::log10(high);
    const double air = std::max(0.06 * (last - first), 0.25 - 0.5 * (last - first));
    first -= std::max(air, 0.05), last += std::max(air, 0.05);
  }
};

/// A line of the grid.
struct Tick {
  double value;
  bool decade, labelled;
};

std::vector<Tick> ticks_of(const Axis& axis) {
  const bool few_decades = axis.last - axis.first < 2.5;
  std::vector<Tick> ticks;
  for (int exponent = static_cast<int>(std::floor(axis.first)); exponent <= axis.last; ++exponent) {
    for (int digit = 1; digit < 10; ++digit) {
      const double value = digit * std::pow(10, exponent), at = std::log10(value);
      if (at < axis.first || at > axis.last) continue;
      ticks.push_back({value, digit == 1, digit == 1 || (few_decades && (digit == 2 || digit == 5))});
    }
  }
  return ticks;
}

class Drawing {
 public:
  Drawing(cairo_t* cairo, const LogLogPlot& plot) : cairo_(cairo), plot_(plot) {
    double low_x = HUGE_VAL, high_x = 0, low_y = HUGE_VAL, high_y = 0;
    for (const PlotSeries& series : plot.series) {
      for (const PlotPoint& p : series.points) {
        if (!can_draw(p)) continue;
        low_x = std::min(low_x, p.x), high_x = std::max(high_x, p.x);
        low_y = std::min(low_y, has_bar(p) ? bar_low(p) : p.y),
        high_y = std::max(high_y, has_bar(p) ? bar_high(p) : p.y);
      }
    }
    x_.fit(low_x, high_x), y_.fit(low_y, high_y);
    x_.begin = kPlotLeft, x_.end = kWidth - kLegendWidth - 30;
    y_.begin = kPlotBottom, y_.end = kPlotTop;
  }

  void draw() {
    set(Color{1, 1, 1});
    cairo_paint(cairo_);
    draw_titles();
    draw_grid();
    for (std::size_t i = 0; i < plot_.series.size(); ++i) draw_series(plot_.series[i], i);
    draw_legend();
  }

 private:
  void set(const Color& c, double alpha = 1) { cairo_set_source_rgba(cairo_, c.r, c.g, c.b, alpha); }
  void line(double x0, double y0, double x1, double y1) {
    cairo_move_to(cairo_, x0, y0);
    cairo_line_to(cairo_, x1, y1);
    cairo_stroke(cairo_);
  }
  double width_of(const std::string& text, double size) {
    cairo_set_font_size(cairo_, size);
    cairo_text_extents_t extents;
    cairo_text_extents(cairo_, text.c_str(), &extents);
    return extents.x_advance;
  }
  void text(const std::string& text, double x, double y, double size, Align align, bool bold = false) {
    cairo_select_font_face(cairo_, "sans-serif", CAIRO_FONT_SLANT_NORMAL,
                           bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
    const double width = width_of(text, size);
    cairo_move_to(cairo_, x - (align == Align::kLeft ? 0 : align == Align::kMiddle ? width / 2 : width), y);
    cairo_show_text(cairo_, text.c_str());
  }

  void draw_titles() {
    set(kInk);
    text(plot_.title, kPlotLeft, 48, 25, Align::kLeft, true);
    text(plot_.x_label, (x_.begin + x_.end) / 2, kHeight - 28, 17, Align::kMiddle);
    cairo_save(cairo_);
    cairo_translate(cairo_, 34, (y_.begin + y_.end) / 2);
    cairo_rotate(cairo_, -M_PI / 2);
    text(plot_.y_label, 0, 0, 17, Align::kMiddle);
    cairo_restore(cairo_);
    set(kFaint);
    text(plot_.subtitle, kPlotLeft, 76, 15, Align::kLeft);
  }

  /// Numbers near 1 as they are, others as powers of ten.
  void label(double value, double x, double y, Align align) {
    if (value > 0.0009 && value < 9999) return text(absl::StrFormat("%g", value), x, y, 15, align);
    const int exponent = static_cast<int>(std::floor(std::log10(value) + 1e-9));
    const int digit = static_cast<int>(std::lround(value / std::pow(10, exponent)));
    const std::string base = digit == 1 ? "10" : absl::StrCat(digit, "\u00b710"),
                      power = absl::StrFormat("%d", exponent);
    const double width = width_of(base, 15) + width_of(power, 11);
    const double start = x - (align == Align::kRight ? width : width / 2);
    text(base, start, y, 15, Align::kLeft);
    text(power, start + width_of(base, 15), y - 7, 11, Align::kLeft);
  }

  void draw_grid() {
    for (const bool decades : {false, true}) {
      for (const Axis* axis : {&x_, &y_}) {
        for (const Tick& tick : ticks_of(*axis)) {
          if (tick.decade != decades) continue;
          const double at = axis->place(tick.value);
          set(decades ? kGrid : kFineGrid);
          cairo_set_line_width(cairo_, decades ? 1.5 : 1);
          axis == &x_ ? line(at, y_.begin, at, y_.end) : line(x_.begin, at, x_.end, at);
          if (!tick.labelled) continue;
          set(kFaint);
          axis == &x_ ? label(tick.value, at, y_.begin + 26, Align::kMiddle)
                      : label(tick.value, x_.begin - 12, at + 5, Align::kRight);
        }
      }
    }
    set(kInk);
    cairo_set_line_width(cairo_, 1.5);
    line(x_.begin, y_.begin, x_.end, y_.begin);
    line(x_.begin, y_.begin, x_.begin, y_.end);
  }

  std::size_t color_of(std::size_t index) const { return plot_.series[index].color.value_or(index); }
  void set_style(std::size_t index) {
    set(kColors[color_of(index) % kColors.size()]);
    constexpr double kDashes[] = {9, 5};
    cairo_set_dash(cairo_, kDashes, plot_.series[index].dashed ? 2 : 0, 0);
    cairo_set_line_width(cairo_, 2.6);
  }
  /// Discs first, then squares of the same colours.
  void draw_marker(std::size_t index, double x, double y) {
    constexpr double kRadius = 5.2;
    cairo_set_dash(cairo_, nullptr, 0, 0);
    if (color_of(index) / kColors.size() % 2 == 0) {
      cairo_arc(cairo_, x, y, kRadius, 0, 2 * M_PI);
    } else {
      cairo_rectangle(cairo_, x - kRadius, y - kRadius, 2 * kRadius, 2 * kRadius);
    }
    cairo_fill(cairo_);
  }

  void draw_series(const PlotSeries& series, std::size_t index) {
    set_style(index);
    cairo_set_line_join(cairo_, CAIRO_LINE_JOIN_ROUND);
    for (const PlotPoint& p : series.points) {
      if (can_draw(p)) cairo_line_to(cairo_, x_.place(p.x), y_.place(p.y));
    }
    cairo_stroke(cairo_);
    for (const PlotPoint& p : series.points) {
      if (!can_draw(p)) continue;
      const double x = x_.place(p.x);
      draw_marker(index, x, y_.place(p.y));
      if (!has_bar(p)) continue;
      cairo_set_line_width(cairo_, 1.6);
      line(x, y_.place(bar_low(p)), x, y_.place(bar_high(p)));
      // One that goes on has no end.
      for (const double end : {p.low, p.high}) {
        if (end == bar_low(p) || end == bar_high(p)) line(x - 5, y_.place(end), x + 5, y_.place(end));
      }
    }
  }

  void draw_legend() {
    const auto named =
        std::ranges::count_if(plot_.series, [](const PlotSeries& s) { return !s.name.empty(); });
    if (named == 0) return;
    const double x = kWidth - kLegendWidth,
                 step = std::min(30.0, (kPlotBottom - kPlotTop) / static_cast<double>(named));
    double size = std::clamp(step * 0.55, 7.0, 15.5), widest = 1;
    for (const PlotSeries& series : plot_.series) widest = std::max(widest, width_of(series.name, size));
    size *= std::min(1.0, (kLegendWidth - 48 - 16) / widest);  // long names are written smaller
    double y = kPlotTop + 8 - step;
    for (std::size_t i = 0; i < plot_.series.size(); ++i) {
      if (plot_.series[i].name.empty()) continue;
      y += step;
      set_style(i);
      line(x, y, x + 36, y);
      draw_marker(i, x + 18, y);
      set(kInk);
      text(plot_.series[i].name, x + 48, y + size * 0.35, size, Align::kLeft);
    }
  }

  cairo_t* const cairo_;
  const LogLogPlot& plot_;
  Axis x_, y_;
};

}  // namespace

absl::Status write_plot(const LogLogPlot& plot, const std::string& path) {
  if (auto s = check_plot_path(path); !s.ok()) return s;
  const bool any = std::ranges::any_of(
      plot.series, [](const PlotSeries& series) { return std::ranges::any_of(series.points, can_draw); });
  if (!any) return absl::InvalidArgumentError(absl::StrCat(path, ": there is nothing to plot"));
  return draw_file(path, kWidth, kHeight, [&](cairo_t* cairo) { Drawing(cairo, plot).draw(); });
}

}  // namespace tessera::client
