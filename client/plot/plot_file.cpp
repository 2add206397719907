#include "plot/plot_file.h"

#include <cairo-svg.h>

#include <memory>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "image/atomic_file.h"
#include "plot/log_log_plot.h"

namespace tessera::client {
namespace {

constexpr int kPngScale = 2;

using Surface = std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)>;

absl::Status status_of(cairo_status_t status, const std::string& path) {
  if (status == CAIRO_STATUS_SUCCESS) return absl::OkStatus();
  return absl::InternalError(absl::StrCat(path, ": cannot draw: ", cairo_status_to_string(status)));
}

absl::Status draw_new_file(const std::string& path, bool svg, double width, double height,
                           const std::function<void(cairo_t*)>& draw) {
  const Surface surface(
      svg ? cairo_svg_surface_create(path.c_str(), width, height)
          : cairo_image_surface_create(CAIRO_FORMAT_RGB24, int(width) * kPngScale, int(height) * kPngScale),
      &cairo_surface_destroy);
  {
    const std::unique_ptr<cairo_t, decltype(&cairo_destroy)> cairo(cairo_create(surface.get()),
                                                                   &cairo_destroy);
    if (!svg) cairo_scale(cairo.get(), kPngScale, kPngScale);
    draw(cairo.get());
    if (auto s = status_of(cairo_status(cairo.get()), path); !s.ok()) return s;
  }
  cairo_surface_flush(surface.get());
  if (!svg) return status_of(cairo_surface_write_to_png(surface.get(), path.c_str()), path);
  cairo_surface_finish(surface.get());
  return status_of(cairo_surface_status(surface.get()), path);
}

}  // namespace

absl::Status check_plot_path(const std::string& path) {
  if (absl::EndsWithIgnoreCase(path, ".png") || absl::EndsWithIgnoreCase(path, ".svg"))
    return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(path, ": plots are written as .png or .svg"));
}

absl::Status draw_file(const std::string& path, double width, double height,
                       const std::function<void(cairo_t*)>& draw) {
  const bool svg = absl::EndsWithIgnoreCase(path, ".svg");
  return replace_file(path,
                      [&](const std::string& file) { return draw_new_file(file, svg, width, height, draw); });
}

}  // namespace tessera::client
