#include <cairo.h>

#include <cmath>
#include <memory>

#include "plot/canvas.h"
#include "plot/log_log_plot.h"
#include "plot/plot_file.h"

namespace tessera::client {
namespace {

using CairoSurface = std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)>;

/// A copy of the pixels, for cairo, which takes blue first in a word of 32 bits.
CairoSurface surface_of(const Pixels& pixels) {
  CairoSurface surface(cairo_image_surface_create(CAIRO_FORMAT_RGB24, static_cast<int>(pixels.width),
                                                  static_cast<int>(pixels.height)),
                       &cairo_surface_destroy);
  unsigned char* const bytes = cairo_image_surface_get_data(surface.get());
  if (bytes == nullptr) return surface;
  cairo_surface_flush(surface.get());
  const auto stride = static_cast<std::size_t>(cairo_image_surface_get_stride(surface.get()));
  for (std::size_t y = 0; y < pixels.height; ++y) {
    auto* const row = reinterpret_cast<std::uint32_t*>(bytes + y * stride);
    for (std::size_t x = 0; x < pixels.width; ++x) {
      const PageColor& color = pixels.colors[y * pixels.width + x];
      row[x] = std::uint32_t{color[0]} << 16 | std::uint32_t{color[1]} << 8 | color[2];
    }
  }
  cairo_surface_mark_dirty(surface.get());
  return surface;
}

class CairoCanvas final : public Canvas {
 public:
  explicit CairoCanvas(cairo_t* cairo) : cairo_(cairo) {}

  void line(std::span<const PagePoint> points, bool closed, const Stroke& stroke) override {
    if (points.empty()) return;
    cairo_new_path(cairo_);
    for (const PagePoint& point : points) cairo_line_to(cairo_, point.x, point.y);
    if (closed) cairo_close_path(cairo_);
    set(stroke.paint);
    constexpr double kDashes[] = {5, 3};
    cairo_set_dash(cairo_, kDashes, stroke.dashed ? 2 : 0, 0);
    cairo_set_line_width(cairo_, stroke.width);
    cairo_set_line_join(cairo_, CAIRO_LINE_JOIN_ROUND);
    cairo_stroke(cairo_);
  }

  void rectangle(const PageBox& box, const Paint& fill) override {
    set(fill);
    cairo_rectangle(cairo_, box.x, box.y, box.width, box.height);
    cairo_fill(cairo_);
  }

  void disc(const PagePoint& middle, double radius, const Paint& fill) override {
    set(fill);
    cairo_new_path(cairo_);
    cairo_arc(cairo_, middle.x, middle.y, radius, 0, 2 * M_PI);
    cairo_fill(cairo_);
  }

  void text(const std::string& text, const PagePoint& at, const TextStyle& style) override {
    cairo_save(cairo_);
    cairo_select_font_face(cairo_, "sans-serif", CAIRO_FONT_SLANT_NORMAL,
                           style.bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(cairo_, style.size);
    cairo_text_extents_t extents;
    cairo_text_extents(cairo_, text.c_str(), &extents);
    cairo_translate(cairo_, at.x, at.y);
    cairo_rotate(cairo_, style.turned);
    const double share = style.align == TextAlign::kLeft ? 0 : style.align == TextAlign::kMiddle ? 0.5 : 1;
    cairo_move_to(cairo_, -share * extents.x_advance, 0);
    if (style.halo) {
      cairo_text_path(cairo_, text.c_str());
      set(*style.halo);
      cairo_set_dash(cairo_, nullptr, 0, 0);
      cairo_set_line_join(cairo_, CAIRO_LINE_JOIN_ROUND);
      cairo_set_line_width(cairo_, 0.32 * style.size);
      cairo_stroke(cairo_);
      cairo_move_to(cairo_, -share * extents.x_advance, 0);
    }
    set(style.paint);
    cairo_show_text(cairo_, text.c_str());
    cairo_restore(cairo_);
  }

  void pixels(const PageBox& box, const Pixels& pixels) override {
    if (pixels.width == 0 || pixels.height == 0) return;
    const CairoSurface surface = surface_of(pixels);
    cairo_save(cairo_);
    cairo_translate(cairo_, box.x, box.y);
    cairo_scale(cairo_, box.width / pixels.width, box.height / pixels.height);
    cairo_set_source_surface(cairo_, surface.get(), 0, 0);
    cairo_pattern_set_filter(cairo_get_source(cairo_), CAIRO_FILTER_NEAREST);
    cairo_rectangle(cairo_, 0, 0, pixels.width, pixels.height);
    cairo_fill(cairo_);
    cairo_restore(cairo_);
  }

 private:
  void set(const Paint& paint) {
    cairo_set_source_rgb(cairo_, paint.color[0] / 255.0, paint.color[1] / 255.0, paint.color[2] / 255.0);
  }

  cairo_t* const cairo_;
};

}  // namespace

absl::Status write_drawing(const std::string& path, double width, double height, const DrawOn& draw) {
  if (auto s = check_plot_path(path); !s.ok()) return s;
  return draw_file(path, width, height, [&](cairo_t* cairo) {
    cairo_set_source_rgb(cairo, 1, 1, 1);
    cairo_paint(cairo);
    CairoCanvas canvas(cairo);
    draw(canvas);
  });
}

std::string png_of(const Pixels& pixels) {
  const CairoSurface surface = surface_of(pixels);
  std::string bytes;
  const auto append = [](void* to, const unsigned char* data, unsigned length) {
    static_cast<std::string*>(to)->append(reinterpret_cast<const char*>(data), length);
    return CAIRO_STATUS_SUCCESS;
  };
  return cairo_surface_write_to_png_stream(surface.get(), append, &bytes) == CAIRO_STATUS_SUCCESS ? bytes
                                                                                                  : "";
}

}  // namespace tessera::client
