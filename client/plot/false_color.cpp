#include "plot/false_color.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "absl/strings/str_cat.h"
#include "plot/isoline_labels.h"

namespace tessera::client {
namespace {

constexpr double kMapMargin = 16, kTitleHeight = 30, kSubtitleHeight = 18, kAxisWidth = 52, kAxisHeight = 42;
constexpr double kLegendGap = 18, kLegendBar = 16, kLegendText = 84;
constexpr double kSmallestMap = 420, kLeastMapSide = 120;
constexpr double kLabelSize = 11;
/// Middles of isolines' cells along the longer side: finer ones would show noise.
constexpr std::size_t kMostIsolineCells = 256;

bool has_axes(const FalseColorOptions& options) { return options.width > 0 && options.height > 0; }

/// A label's length is not known before it is drawn; digits of the usual fonts are about as wide.
double text_length(const std::string& text, double size) {
  const auto characters = std::ranges::count_if(text, [](char c) { return (c & 0xc0) != 0x80; });
  return 0.6 * size * static_cast<double>(characters);
}

/// Values between the middles of cells, linear along both sides; missing where one of the four is.
double value_between(const ValueGrid& grid, double x, double y) {
  const auto bounded = [](double at, std::size_t count) {
    return std::clamp(at - 0.5, 0.0, static_cast<double>(count - 1));
  };
  x = bounded(x, grid.columns), y = bounded(y, grid.rows);
  const auto column = static_cast<std::size_t>(x), row = static_cast<std::size_t>(y);
  const std::size_t right = std::min(column + 1, grid.columns - 1), down = std::min(row + 1, grid.rows - 1);
  const double u = x - static_cast<double>(column), v = y - static_cast<double>(row);
  return std::lerp(std::lerp(grid.at(column, row), grid.at(right, row), u),
                   std::lerp(grid.at(column, down), grid.at(right, down), u), v);
}

/// The parts of a map in the order in which they lie over each other.
class FalseColorDrawing {
 public:
  FalseColorDrawing(Canvas& canvas, const ValueGrid& grid, const FalseColorOptions& options)
      : canvas_(canvas),
        grid_(grid),
        options_(options),
        layout_(false_color_layout(grid, options)),
        scale_(scale_over(grid.values, options.scale, options.range, options.cut)),
        ticks_(ticks_on(scale_)) {}

  void draw() {
    draw_titles();
    canvas_.pixels(layout_.map, colors());
    if (options_.isolines) draw_isolines();
    outline(layout_.map);
    if (has_axes(options_)) draw_axes();
    draw_legend();
  }

 private:
  void outline(const PageBox& box) {
    const PagePoint corners[] = {{box.x, box.y},
                                 {box.x + box.width, box.y},
                                 {box.x + box.width, box.y + box.height},
                                 {box.x, box.y + box.height}};
    canvas_.line(corners, true, {.paint = kPageFaint, .width = 1});
  }

  /// One pixel a cell, or as many as the page has of them for values between the middles.
  Pixels colors() const {
    const PageColor missing = options_.ground.value_or(kMissingColor);
    if (!options_.smooth) return false_color_pixels(grid_, scale_, options_.map, missing);
    const auto pixels = [&](double length, std::size_t cells) {
      const double each = length / layout_.pixel / static_cast<double>(cells);
      return static_cast<std::size_t>(std::max(1.0, std::floor(each)));
    };
    const ValueGrid fine = enlarged(grid_, pixels(layout_.map.width, grid_.columns),
                                    pixels(layout_.map.height, grid_.rows), true);
    return false_color_pixels(fine, scale_, options_.map, missing);
  }

  void draw_titles() {
    double y = kMapMargin + 14;
    if (!options_.title.empty()) {
      canvas_.text(options_.title, {layout_.map.x, y}, {.size = 16, .bold = true});
      y += 20;
    }
    if (!options_.subtitle.empty())
      canvas_.text(options_.subtitle, {layout_.map.x, y}, {.size = 12, .paint = kPageFaint});
  }

  void draw_isolines() {
    const std::size_t longest = std::max(grid_.columns, grid_.rows);
    const std::size_t factor = (longest + kMostIsolineCells - 1) / kMostIsolineCells;
    const ValueGrid coarse = factor > 1 ? reduced(grid_, factor) : ValueGrid{};
    const ValueGrid& grid = factor > 1 ? coarse : grid_;
    // The last blocks of a reduced grid reach over its edge.
    const double cell = layout_.map.width / static_cast<double>(grid_.columns) * static_cast<double>(factor);
    std::vector<PagePoint> taken;
    for (const ScaleTick& tick : ticks_) {
      const double place = scale_.place(tick.value);
      if (!(place > 1e-6 && place < 1 - 1e-6)) continue;
      const PageColor behind = map_color(options_.map, place);
      for (const Isoline& line : isolines(grid, tick.value)) {
        if (length_of(line) * static_cast<double>(factor) < options_.shortest_isoline) continue;
        draw_isoline(line, cell, tick.label, behind, taken);
      }
    }
    for (const auto& [text, place, behind] : labels_) {
      // The base line lies below the middle of the letters.
      const double down = 0.35 * kLabelSize;
      canvas_.text(text,
                   {place.at.x - down * std::sin(place.turned), place.at.y + down * std::cos(place.turned)},
                   {.size = kLabelSize,
                    .align = TextAlign::kMiddle,
                    .turned = place.turned,
                    .paint = {contrast_to(behind)},
                    .halo = Paint{behind}});
    }
  }

  void draw_isoline(const Isoline& line, double cell, const std::string& label, const PageColor& behind,
                    std::vector<PagePoint>& taken) {
    std::vector<PagePoint> points;
    for (const PagePoint& point : line.points)
      points.push_back({layout_.map.x + cell * point.x, layout_.map.y + cell * row_scale() * point.y});
    canvas_.line(points, line.closed, {.paint = {contrast_to(behind)}, .width = 1});
    if (line.closed) points.push_back(points.front());
    const double length = text_length(label, kLabelSize) + 4;
    const std::optional<LabelPlace> place = label_place(points, length, layout_.map, taken);
    if (!place) return;
    taken.push_back(place->at);
    labels_.push_back({label, *place, behind});
  }

  /// Height of a cell over its width.
  double row_scale() const {
    return layout_.map.height / static_cast<double>(grid_.rows) /
           (layout_.map.width / static_cast<double>(grid_.columns));
  }

  void draw_axes() {
    const PageBox& map = layout_.map;
    const auto ticks = [&](double length, double points) {
      return ticks_on({ScaleKind::kLinear, 0, length}, std::max(2, static_cast<int>(points / 70)));
    };
    const TextStyle style{.size = kLabelSize, .align = TextAlign::kMiddle, .paint = kPageFaint};
    for (const ScaleTick& tick : ticks(options_.width, map.width)) {
      const double x = map.x + tick.value / options_.width * map.width, y = map.y + map.height;
      const PagePoint mark[] = {{x, y}, {x, y + 4}};
      canvas_.line(mark, false, {.paint = kPageFaint});
      canvas_.text(tick.label, {x, y + 17}, style);
    }
    // The origin is the lower left corner.
    for (const ScaleTick& tick : ticks(options_.height, map.height)) {
      const double y = map.y + map.height - tick.value / options_.height * map.height;
      const PagePoint mark[] = {{map.x, y}, {map.x - 4, y}};
      canvas_.line(mark, false, {.paint = kPageFaint});
      canvas_.text(tick.label, {map.x - 8, y + 4},
                   {.size = kLabelSize, .align = TextAlign::kRight, .paint = kPageFaint});
    }
    const std::string unit = options_.length_unit.empty() ? "" : absl::StrCat(" / ", options_.length_unit);
    canvas_.text(absl::StrCat("u", unit), {map.x + map.width / 2, map.y + map.height + 33}, style);
    TextStyle turned = style;
    turned.turned = -M_PI / 2;
    canvas_.text(absl::StrCat("v", unit), {map.x - kAxisWidth + 14, map.y + map.height / 2}, turned);
  }

  void draw_legend() {
    const bool some_missing =
        !options_.ground && std::ranges::any_of(grid_.values, [](double value) { return std::isnan(value); });
    const PageBox bar{layout_.map.x + layout_.map.width + kLegendGap, layout_.map.y + 18, kLegendBar,
                      std::max(60.0, layout_.map.height - 18 - (some_missing ? 26 : 0))};
    constexpr std::uint32_t kSteps = 256;
    Pixels colors{1, kSteps, {}};
    for (std::uint32_t i = 0; i < kSteps; ++i)
      colors.colors.push_back(map_color(options_.map, 1 - (i + 0.5) / kSteps));
    canvas_.pixels(bar, colors);
    outline(bar);
    canvas_.text(options_.unit, {bar.x, layout_.map.y + 9}, {.size = 13, .bold = true});
    draw_legend_ticks(bar);
    if (!some_missing) return;
    const PageBox missing{bar.x, bar.y + bar.height + 12, kLegendBar, 14};
    canvas_.rectangle(missing, {kMissingColor});
    canvas_.text("none", {bar.x + bar.width + 8, missing.y + 11}, {.size = 12});
  }

  void draw_legend_ticks(const PageBox& bar) {
    const auto is_any = [&](auto&& beyond) {
      return std::ranges::any_of(grid_.values, [&](double value) { return beyond(scale_.place(value)); });
    };
    const bool above = is_any([](double place) { return place > 1 + 1e-9; }),
               below = is_any([](double place) { return place < -1e-9; });
    for (std::size_t i = 0; i < ticks_.size(); ++i) {
      const double place = scale_.place(ticks_[i].value), y = bar.y + (1 - place) * bar.height;
      const PagePoint mark[] = {{bar.x + bar.width, y}, {bar.x + bar.width + 4, y}};
      canvas_.line(mark, false, {.paint = kPageFaint});
      const bool last = i + 1 == ticks_.size() && place > 1 - 1e-6, first = i == 0 && place < 1e-6;
      const char* const beyond = last && above ? "\u2265 " : first && below ? "\u2264 " : "";
      canvas_.text(absl::StrCat(beyond, ticks_[i].label), {bar.x + bar.width + 8, y + 4}, {.size = 12});
    }
  }

  struct IsolineLabel {
    std::string text;
    LabelPlace place;
    PageColor behind;
  };

  Canvas& canvas_;
  const ValueGrid& grid_;
  const FalseColorOptions& options_;
  const FalseColorLayout layout_;
  const ValueScale scale_;
  const std::vector<ScaleTick> ticks_;
  std::vector<IsolineLabel> labels_;
};

}  // namespace

FalseColorLayout false_color_layout(const ValueGrid& grid, const FalseColorOptions& options) {
  constexpr double kPixel = 0.5;  // points that a pixel of a PNG takes (write_drawing)
  const auto columns = static_cast<double>(std::max<std::size_t>(grid.columns, 1)),
             rows = static_cast<double>(std::max<std::size_t>(grid.rows, 1));
  FalseColorLayout layout;
  layout.pixel = kPixel;
  double aspect = rows / columns;  // of the whole map
  if (has_axes(options)) aspect = std::clamp(options.height / options.width, 0.05, 20.0);
  // Wide maps are measured by their width, high ones by their height: whole pixels a cell along that side.
  const double along = aspect <= 1 ? columns : rows;
  const double side = std::max(kPixel * along, kPixel * along * std::ceil(kSmallestMap / (kPixel * along)));
  layout.map.width = aspect <= 1 ? side : std::max(side / aspect, 1.0);
  layout.map.height = aspect <= 1 ? side * aspect : side;
  const double axis = has_axes(options) ? kAxisWidth : 0;
  layout.map.x = kMapMargin + axis;
  layout.map.y = kMapMargin + (options.title.empty() ? 0 : kTitleHeight) +
                 (options.subtitle.empty() ? 0 : kSubtitleHeight);
  layout.page_width = layout.map.x + layout.map.width + kLegendGap + kLegendBar + kLegendText;
  layout.page_height = layout.map.y + std::max(layout.map.height, kLeastMapSide) +
                       (has_axes(options) ? kAxisHeight : kMapMargin);
  return layout;
}

ValueGrid enlarged(const ValueGrid& grid, std::size_t across, std::size_t down, bool smooth) {
  ValueGrid large{grid.columns * across, grid.rows * down, {}};
  large.values.reserve(large.columns * large.rows);
  for (std::size_t y = 0; y < large.rows; ++y) {
    const double v = (static_cast<double>(y) + 0.5) / static_cast<double>(down);
    for (std::size_t x = 0; x < large.columns; ++x) {
      const double u = (static_cast<double>(x) + 0.5) / static_cast<double>(across);
      large.values.push_back(smooth ? value_between(grid, u, v) : grid.at(x / across, y / down));
    }
  }
  return large;
}

Pixels false_color_pixels(const ValueGrid& grid, const ValueScale& scale, ColorMap map,
                          const PageColor& missing) {
  Pixels pixels{static_cast<std::uint32_t>(grid.columns), static_cast<std::uint32_t>(grid.rows), {}};
  pixels.colors.reserve(grid.values.size());
  for (const double value : grid.values)
    pixels.colors.push_back(std::isnan(value) ? missing : map_color(map, scale.place(value)));
  return pixels;
}

void draw_false_color(Canvas& canvas, const ValueGrid& grid, const FalseColorOptions& options) {
  FalseColorDrawing(canvas, grid, options).draw();
}

absl::Status write_false_color(const ValueGrid& grid, const FalseColorOptions& options,
                               const std::string& path) {
  if (grid.values.empty() || grid.values.size() != grid.columns * grid.rows)
    return absl::InvalidArgumentError(absl::StrCat(path, ": there are no values to show"));
  const FalseColorLayout layout = false_color_layout(grid, options);
  return write_drawing(path, std::ceil(layout.page_width), std::ceil(layout.page_height),
                       [&](Canvas& canvas) { draw_false_color(canvas, grid, options); });
}

}  // namespace tessera::client
