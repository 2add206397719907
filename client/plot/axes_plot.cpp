#include "plot/axes_plot.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"

namespace tessera::client {
namespace {

constexpr double kPlotMargin = 18, kScaleWidth = 68, kScaleHeight = 46, kHeadHeight = 34;
constexpr double kTickSize = 11;

bool is_drawn(const PlotPoint& point) { return std::isfinite(point.x) && std::isfinite(point.y); }
bool has_interval(const PlotPoint& point) {
  return std::isfinite(point.low) && std::isfinite(point.high) && point.high > point.low;
}

class AxesDrawing {
 public:
  AxesDrawing(Canvas& canvas, const AxesPlot& plot) : canvas_(canvas), plot_(plot) {
    std::vector<double> x, y;
    for (const AxesPlot::Bar& bar : plot.bars) {
      x.insert(x.end(), {bar.from, bar.to});
      y.insert(y.end(), {0, bar.height});
    }
    for (const PlotPoint& point : plot.points) {
      if (!is_drawn(point)) continue;
      x.push_back(point.x);
      y.push_back(point.y);
      if (has_interval(point)) y.insert(y.end(), {point.low, point.high});
    }
    if (plot.x_range) x = {plot.x_range->low, plot.x_range->high};
    // Along x all is shown, and nothing more: values of a plane begin at its edge.
    if (!x.empty()) {
      const auto [least, most] = std::ranges::minmax(x);
      if (most > least) x_ = {plot.x_scale, least, most};
    }
    y_ = scale_over(y, ScaleKind::kLinear);
  }

  void draw() {
    if (!plot_.title.empty())
      canvas_.text(plot_.title, {area_.x, kPlotMargin + 8}, {.size = 14, .bold = true});
    draw_y_ticks();
    for (const AxesPlot::Bar& bar : plot_.bars) draw_bar(bar);
    draw_points();
    draw_x_ticks();
    const PagePoint corner[] = {{area_.x, area_.y},
                                {area_.x, area_.y + area_.height},
                                {area_.x + area_.width, area_.y + area_.height}};
    canvas_.line(corner, false, {.paint = kPageFaint});
  }

 private:
  double x_of(double value) const { return area_.x + std::clamp(x_.place(value), 0.0, 1.0) * area_.width; }
  double y_of(double value) const {
    return area_.y + (1 - std::clamp(y_.place(value), 0.0, 1.0)) * area_.height;
  }

  void draw_y_ticks() {
    for (const ScaleTick& tick : ticks_on(y_, 5)) {
      const double y = y_of(tick.value);
      const PagePoint line[] = {{area_.x, y}, {area_.x + area_.width, y}};
      canvas_.line(line, false, {.paint = kPageGrid});
      canvas_.text(tick.label, {area_.x - 7, y + 4},
                   {.size = kTickSize, .align = TextAlign::kRight, .paint = kPageFaint});
    }
    canvas_.text(plot_.y_label, {kPlotMargin + 2, area_.y + area_.height / 2},
                 {.size = 12, .align = TextAlign::kMiddle, .turned = -M_PI / 2, .paint = kPageFaint});
  }

  void draw_x_ticks() {
    const double bottom = area_.y + area_.height;
    for (const ScaleTick& tick : ticks_on(x_, 7)) {
      const double x = x_of(tick.value);
      const PagePoint line[] = {{x, bottom}, {x, bottom + 4}};
      canvas_.line(line, false, {.paint = kPageFaint});
      canvas_.text(tick.label, {x, bottom + 17},
                   {.size = kTickSize, .align = TextAlign::kMiddle, .paint = kPageFaint});
    }
    canvas_.text(plot_.x_label, {area_.x + area_.width / 2, bottom + 35},
                 {.size = 12, .align = TextAlign::kMiddle, .paint = kPageFaint});
  }

  void draw_bar(const AxesPlot::Bar& bar) {
    if (!(bar.height > 0)) return;
    const double left = x_of(bar.from), top = y_of(bar.height);
    const PageBox box{left, top, std::max(0.5, x_of(bar.to) - left - 1), area_.y + area_.height - top};
    canvas_.rectangle(box, bar.color ? Paint{*bar.color} : kPageData);
  }

  void draw_points() {
    constexpr std::size_t kMostDiscs = 64;
    std::vector<PagePoint> line;
    const auto finish = [&] {
      if (line.size() > 1) canvas_.line(line, false, {.paint = kPageData, .width = 1.5});
      line.clear();
    };
    for (const PlotPoint& point : plot_.points) {
      if (!is_drawn(point)) {
        finish();
        continue;
      }
      const double x = x_of(point.x);
      line.push_back({x, y_of(point.y)});
      if (has_interval(point)) draw_interval(x, y_of(point.low), y_of(point.high));
      if (plot_.points.size() <= kMostDiscs) canvas_.disc(line.back(), 2.4, kPageData);
    }
    finish();
  }

  void draw_interval(double x, double low, double high) {
    const PagePoint bar[] = {{x, low}, {x, high}}, foot[] = {{x - 2.5, low}, {x + 2.5, low}},
                    head[] = {{x - 2.5, high}, {x + 2.5, high}};
    for (const auto& part : {bar, foot, head})
      canvas_.line({part, 2}, false, {.paint = kPageFaint, .width = 1});
  }

  Canvas& canvas_;
  const AxesPlot& plot_;
  const PageBox area_{kPlotMargin + kScaleWidth - 8, kHeadHeight,
                      kAxesPlotWidth - 2 * kPlotMargin - kScaleWidth,
                      kAxesPlotHeight - kHeadHeight - kScaleHeight};
  ValueScale x_, y_;
};

}  // namespace

void draw_axes_plot(Canvas& canvas, const AxesPlot& plot) { AxesDrawing(canvas, plot).draw(); }

absl::Status write_axes_plot(const AxesPlot& plot, const std::string& path) {
  if (plot.bars.empty() && std::ranges::none_of(plot.points, is_drawn))
    return absl::InvalidArgumentError(absl::StrCat(path, ": there is nothing to plot"));
  return write_drawing(path, kAxesPlotWidth, kAxesPlotHeight,
                       [&](Canvas& canvas) { draw_axes_plot(canvas, plot); });
}

AxesPlot histogram_of(std::span<const double> values, const ValueScale& scale, ColorMap map) {
  constexpr double kLeastBars = 8, kMostBars = 40;
  std::vector<double> known;
  std::ranges::copy_if(values, std::back_inserter(known), [](double value) { return std::isfinite(value); });
  AxesPlot plot;
  plot.y_label = "cells", plot.x_scale = scale.kind;
  const auto count = static_cast<std::size_t>(
      std::clamp(std::round(std::sqrt(static_cast<double>(known.size()))), kLeastBars, kMostBars));
  for (std::size_t i = 0; i < count; ++i) {
    const double from = static_cast<double>(i) / static_cast<double>(count),
                 to = static_cast<double>(i + 1) / static_cast<double>(count);
    plot.bars.push_back({scale.value(from), scale.value(to), 0, map_color(map, (from + to) / 2)});
  }
  for (const double value : known) {
    const double place = std::clamp(scale.place(value), 0.0, 1.0) * static_cast<double>(count);
    plot.bars[std::min(count - 1, static_cast<std::size_t>(place))].height += 1;
  }
  return plot;
}

}  // namespace tessera::client
