#include "measure/report/mesh_maps.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "base/printable.h"
#include "image/atomic_file.h"
#include "image/exr.h"
#include "measure/report/figure_text.h"
#include "measure/report/plane_summary.h"

namespace tessera::client {
namespace {

using Imath::V3d;

constexpr double kNoValue = std::numeric_limits<double>::quiet_NaN();

/// Corners in the order that runs counterclockwise about the side that was measured.
std::array<V3d, 3> corners_of(const MeasuredMesh& mesh, std::size_t number) {
  const std::array<std::uint32_t, 3>& triangle = mesh.triangles[number];
  std::array<V3d, 3> corners{mesh.vertices[triangle[0]], mesh.vertices[triangle[1]],
                             mesh.vertices[triangle[2]]};
  if (mesh.turned) std::swap(corners[1], corners[2]);
  return corners;
}

V3d across(const std::array<V3d, 3>& corners) {
  return (corners[1] - corners[0]) % (corners[2] - corners[0]);
}

/// The direction to the eye: of the eight corners of a box, the one from which most area is seen.
V3d eye_direction(const MeasuredMesh& mesh, bool y_up) {
  V3d best(0);
  double most = -1;
  for (const double up : {1.0, -1.0}) {
    for (const double ahead : {-1.0, 1.0}) {
      for (const double right : {1.0, -1.0}) {
        const V3d eye = (y_up ? V3d(right, up, -ahead) : V3d(right, ahead, up)).normalized();
        double seen = 0;
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
          seen += std::max(0.0, across(corners_of(mesh, t)) ^ eye);
        // Closed surfaces show as much from everywhere, but for rounding.
        if (seen > most * (1 + 1e-6)) most = seen, best = eye;
      }
    }
  }
  return best;
}

/// Draws triangles over each other, the nearest one on top.
class MeshRaster {
 public:
  MeshRaster(const MeasuredMesh& mesh, const MeshMapOptions& options) : mesh_(mesh) {
    eye_ = eye_direction(mesh, options.y_up);
    right_ = ((options.y_up ? V3d(0, 1, 0) : V3d(0, 0, 1)) % eye_).normalized();
    up_ = eye_ % right_;
    constexpr double kFar = std::numeric_limits<double>::infinity();
    V3d low(kFar), high(-kFar);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      for (const V3d& corner : corners_of(mesh, t)) {
        const V3d p = seen(corner);
        for (int a = 0; a < 3; ++a) low[a] = std::min(low[a], p[a]), high[a] = std::max(high[a], p[a]);
      }
    }
    const double longer = std::max({high.x - low.x, high.y - low.y, 1e-300});
    constexpr double kAir = 8;  // pixels on each side
    scale_ = std::max(1.0, options.pixels - 2 * kAir) / longer;
    left_ = low.x - kAir / scale_, top_ = high.y + kAir / scale_;
    const auto side = [&](double from, double to) {
      return static_cast<std::size_t>(std::ceil((to - from) * scale_ + 2 * kAir));
    };
    columns_ = side(low.x, high.x), rows_ = side(low.y, high.y);
    triangles_.assign(columns_ * rows_, -1);
    depths_.assign(columns_ * rows_, -kFar);
  }

  void draw() {
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) draw(t);
  }

  std::size_t columns() const { return columns_; }
  std::size_t rows() const { return rows_; }
  std::vector<std::int32_t> take_triangles() { return std::move(triangles_); }

 private:
  V3d seen(const V3d& p) const { return {p ^ right_, p ^ up_, p ^ eye_}; }

  void draw(std::size_t number) {
    std::array<V3d, 3> p = corners_of(mesh_, number);
    // Pixels: x to the right, y down, z to the eye.
    for (V3d& corner : p) {
      const V3d at = seen(corner);
      corner = {(at.x - left_) * scale_, (top_ - at.y) * scale_, at.z};
    }
    const auto edge = [](const V3d& a, const V3d& b, double x, double y) {
      return (b.y - a.y) * (x - a.x) - (b.x - a.x) * (y - a.y);
    };
    const double whole = edge(p[0], p[1], p[2].x, p[2].y);
    // y is down: counterclockwise triangles, which face the eye, are above 0 here.
    if (!(whole > 0)) return;
    const auto range = [](double a, double b, double c, std::size_t most) {
      const double from = std::clamp(std::floor(std::min({a, b, c})), 0.0, static_cast<double>(most)),
                   to = std::clamp(std::ceil(std::max({a, b, c})), 0.0, static_cast<double>(most));
      return std::pair{static_cast<std::size_t>(from), static_cast<std::size_t>(to)};
    };
    const auto [x0, x1] = range(p[0].x, p[1].x, p[2].x, columns_);
    const auto [y0, y1] = range(p[0].y, p[1].y, p[2].y, rows_);
    for (std::size_t row = y0; row < y1; ++row) {
      for (std::size_t column = x0; column < x1; ++column) {
        const double x = static_cast<double>(column) + 0.5, y = static_cast<double>(row) + 0.5;
        const double c = edge(p[0], p[1], x, y) / whole, a = edge(p[1], p[2], x, y) / whole,
                     b = edge(p[2], p[0], x, y) / whole;
        if (!(std::min({a, b, c}) >= -1e-9)) continue;
        const double depth = a * p[0].z + b * p[1].z + c * p[2].z;
        const std::size_t pixel = row * columns_ + column;
        if (!(depth > depths_[pixel])) continue;
        depths_[pixel] = depth;
        triangles_[pixel] = static_cast<std::int32_t>(number);
      }
    }
  }

  const MeasuredMesh& mesh_;
  V3d eye_, right_, up_;
  double scale_ = 1, left_ = 0, top_ = 0;  // pixels a unit; the upper left corner
  std::size_t columns_ = 1, rows_ = 1;
  std::vector<std::int32_t> triangles_;
  std::vector<double> depths_;
};

absl::Status check(const MeasuredMeter& meter, const MeasuredMesh& mesh) {
  if (!mesh.triangles.empty() && is_within(meter, mesh)) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat("meter '", meter.name, "' has ", meter.readings.size(),
                                                 " readings, too few for ", mesh.triangles.size(),
                                                 " triangles from the ", mesh.first_reading, "th on"));
}

ValueScale scale_of(const MeasuredMeter& meter, const MeasuredMesh& mesh, const PlaneMapOptions& options) {
  std::vector<double> values;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    values.push_back(meter.readings[mesh.first_reading + t].figure.value);
  return scale_over(values, options.scale, options.range);
}

template <class T>
void put(const T& value, std::string& bytes) {
  static_assert(std::endian::native == std::endian::little, "the format is little-endian");
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

absl::StatusOr<Image> image_of(const MeasuredMeter& meter, const MeasuredMesh& mesh,
                               const MeshMapOptions& options) {
  const auto view = view_of(meter, mesh, options);
  if (!view.ok()) return view.status();
  Image image;
  image.data = image.display = {0, 0, static_cast<std::int32_t>(view->values.columns),
                                static_cast<std::int32_t>(view->values.rows)};
  const auto add = [&](const char* name, const auto& values) {
    std::ranges::transform(values, image.add(name).values.begin(),
                           [](auto value) { return static_cast<float>(value); });
  };
  add("Y", view->values.values);
  add("error.Y", view->errors.values);
  add("triangle", view->triangles);
  image.metadata["tessera.meter"] = meter.name;
  image.metadata["tessera.quantity"] = meter.quantity;
  image.metadata["tessera.unit"] = meter.unit;
  return image;
}

}  // namespace

absl::StatusOr<MeshView> view_of(const MeasuredMeter& meter, const MeasuredMesh& mesh,
                                 const MeshMapOptions& options) {
  if (absl::Status s = check(meter, mesh); !s.ok()) return s;
  MeshRaster raster(mesh, options);
  raster.draw();
  MeshView view;
  view.triangles = raster.take_triangles();
  view.values = view.errors = ValueGrid{raster.columns(), raster.rows(), {}};
  for (const std::int32_t triangle : view.triangles) {
    const Figure figure =
        triangle < 0 ? Figure{.value = kNoValue, .standard_error = kNoValue}
                     : meter.readings[mesh.first_reading + static_cast<std::size_t>(triangle)].figure;
    view.values.values.push_back(figure.value), view.errors.values.push_back(figure.standard_error);
  }
  return view;
}

FalseColorOptions false_color_of(const MeasuredMeter& meter, const MeasuredMesh& mesh,
                                 const PlaneMapOptions& options) {
  FalseColorOptions look;
  look.title = meter.name;
  look.unit = unit_label(meter.unit);
  look.subtitle = absl::StrCat(meter.quantity, " / ", look.unit, ", ", mesh.shape);
  look.map = options.map, look.scale = options.scale;
  const ValueScale scale = scale_of(meter, mesh, options);
  look.range = ValueRange{scale.low, scale.high};
  look.ground = kPageGround.color;
  return look;
}

absl::StatusOr<std::string> mesh_ply(const MeasuredMeter& meter, const MeasuredMesh& mesh,
                                     const PlaneMapOptions& options) {
  if (absl::Status s = check(meter, mesh); !s.ok()) return s;
  const ValueScale scale = scale_of(meter, mesh, options);
  std::string bytes = absl::StrCat(
      "ply\nformat binary_little_endian 1.0\ncomment ", base::printable(meter.name), ": ",
      base::printable(meter.quantity), " in ", base::printable(meter.unit), "\ncomment colours from ",
      short_text(scale.low), " to ", short_text(scale.high), "\nelement vertex ", 3 * mesh.triangles.size(),
      "\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\nproperty uchar "
      "green\nproperty uchar blue\nelement face ",
      mesh.triangles.size(),
      "\nproperty list uchar int vertex_indices\nproperty uchar red\nproperty uchar green\nproperty uchar "
      "blue\nproperty float value\nproperty float standard_error\nend_header\n");
  const auto figure = [&](std::size_t t) -> const Figure& {
    return meter.readings[mesh.first_reading + t].figure;
  };
  const auto color = [&](std::size_t t) {
    return std::isnan(figure(t).value) ? kMissingColor : map_color(options.map, scale.place(figure(t).value));
  };
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (const V3d& corner : corners_of(mesh, t)) {
      for (int a = 0; a < 3; ++a) put(static_cast<float>(corner[a]), bytes);
      put(color(t), bytes);
    }
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    put(std::uint8_t{3}, bytes);
    for (std::size_t k = 0; k < 3; ++k) put(static_cast<std::int32_t>(3 * t + k), bytes);
    put(color(t), bytes);
    put(static_cast<float>(figure(t).value), bytes);
    put(static_cast<float>(figure(t).standard_error), bytes);
  }
  return bytes;
}

absl::Status write_mesh_map(const MeasuredMeter& meter, const MeasuredMesh& mesh,
                            const MeshMapOptions& options, const std::string& path) {
  if (absl::EndsWithIgnoreCase(path, ".ply")) {
    const auto bytes = mesh_ply(meter, mesh, options.maps);
    return bytes.ok() ? replace_file_with(path, *bytes) : bytes.status();
  }
  if (absl::EndsWithIgnoreCase(path, ".exr")) {
    const auto image = image_of(meter, mesh, options);
    return image.ok() ? write_exr(*image, path) : image.status();
  }
  const auto view = view_of(meter, mesh, options);
  if (!view.ok()) return view.status();
  return write_false_color(view->values, false_color_of(meter, mesh, options.maps), path);
}

}  // namespace tessera::client
