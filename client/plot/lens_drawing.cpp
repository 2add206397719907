#include "plot/lens_drawing.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "plot/log_log_plot.h"
#include "plot/plot_file.h"

namespace tessera::client {
namespace {

constexpr double kPageWidth = 1200, kMargin = 40, kTitle = 50, kMostHeight = 1200;
// Told apart by all eyes [Okabe & Ito 2008].
constexpr std::array<std::array<double, 3>, 4> kBundleColors{
    {{0.0, 0.447, 0.698}, {0.835, 0.369, 0.0}, {0.0, 0.62, 0.451}, {0.8, 0.475, 0.655}}};

/// The part that is drawn, in millimetres.
struct LensExtent {
  double first = 0, last = 0, height = 0;

  explicit LensExtent(const LensDrawing& drawing) : first(drawing.film), last(drawing.film) {
    height = drawing.film_height;
    for (const auto& glass : drawing.elements) add(glass.outline);
    for (const auto& blade : drawing.blades) add(blade);
    for (const auto& rays : drawing.bundles) {
      for (const auto& path : rays.paths) add(path);
    }
    height = std::max(height * 1.05, 1e-3);
    last = std::max(last, first + 1e-3);
  }
  void add(const std::vector<DrawnPoint>& points) {
    for (const DrawnPoint p : points) {
      first = std::min(first, p.along), last = std::max(last, p.along);
      height = std::max(height, std::abs(p.height));
    }
  }
};

void add_path(cairo_t* cairo, const std::vector<DrawnPoint>& points) {
  for (std::size_t i = 0; i < points.size(); ++i)
    (i == 0 ? cairo_move_to : cairo_line_to)(cairo, points[i].along, -points[i].height);
}

void draw_lens(cairo_t* cairo, const LensDrawing& drawing, const LensExtent& extent, double scale,
               double height) {
  cairo_set_source_rgb(cairo, 1, 1, 1);
  cairo_paint(cairo);
  cairo_select_font_face(cairo, "sans-serif", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_BOLD);
  cairo_set_font_size(cairo, 20);
  cairo_set_source_rgb(cairo, 0.13, 0.15, 0.18);
  cairo_move_to(cairo, kMargin, 34);
  cairo_show_text(cairo, drawing.title.c_str());
  cairo_translate(cairo, kMargin, kTitle + (height - kTitle) / 2);
  cairo_scale(cairo, scale, scale);
  cairo_translate(cairo, -extent.first, 0);
  const auto wide = [&](double points) { cairo_set_line_width(cairo, points / scale); };

  for (const auto& glass : drawing.elements) {
    add_path(cairo, glass.outline);
    cairo_close_path(cairo);
    const double dark = std::clamp((glass.index - 1.4) * 0.5, 0.0, 0.3);
    cairo_set_source_rgba(cairo, 0.75 - dark, 0.87 - dark, 0.95 - dark / 2, 0.8);
    cairo_fill_preserve(cairo);
    cairo_set_source_rgb(cairo, 0.25, 0.3, 0.35);
    wide(1.2);
    cairo_stroke(cairo);
  }
  wide(0.8);
  cairo_set_source_rgb(cairo, 0.6, 0.6, 0.6);
  add_path(cairo, {{extent.first, 0}, {extent.last, 0}});
  cairo_stroke(cairo);
  for (std::size_t i = 0; i < drawing.bundles.size(); ++i) {
    const auto& color = kBundleColors[i % kBundleColors.size()];
    cairo_set_source_rgba(cairo, color[0], color[1], color[2], 0.8);
    for (const auto& path : drawing.bundles[i].paths) {
      add_path(cairo, path);
      cairo_stroke(cairo);
    }
  }
  cairo_set_source_rgb(cairo, 0.1, 0.1, 0.1);
  wide(3);
  for (const auto& blade : drawing.blades) {
    add_path(cairo, blade);
    cairo_stroke(cairo);
  }
  add_path(cairo, {{drawing.film, -drawing.film_height}, {drawing.film, drawing.film_height}});
  cairo_stroke(cairo);
}

}  // namespace

absl::Status write_lens_drawing(const LensDrawing& drawing, const std::string& path) {
  if (auto s = check_plot_path(path); !s.ok()) return s;
  const LensExtent extent(drawing);
  const double scale = std::min((kPageWidth - 2 * kMargin) / (extent.last - extent.first),
                                (kMostHeight - kTitle - kMargin) / (2 * extent.height));
  const double height = kTitle + 2 * extent.height * scale + kMargin;
  return draw_file(path, kPageWidth, height,
                   [&](cairo_t* cairo) { draw_lens(cairo, drawing, extent, scale, height); });
}

}  // namespace tessera::client
