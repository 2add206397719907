#include "render/scene/view/distortion.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "images/image_blob.h"
#include "render/scene/values/located.h"
#include "render/scene/view/distorted_film.h"

namespace tessera::render {

absl::Status folds_at(const FilmPlaces& film, PlanePoint place, const std::string& more) {
  const PlanePoint pixel = film.pixel_of(place);
  return absl::InvalidArgumentError(absl::StrFormat(
      "camera: its distortion folds the film at pixel (%.0f, %.0f): places there see what others see, or "
      "nothing%s",
      pixel.x, pixel.y, more));
}

void span(const FilmPlaces& film, PlanePoint first_pixel, PlanePoint last_pixel, PlaceGrid& grid) {
  const PlanePoint first = film.at_pixel(first_pixel.x, first_pixel.y),
                   last = film.at_pixel(last_pixel.x, last_pixel.y);
  grid.first_x = static_cast<float>(first.x), grid.first_y = static_cast<float>(first.y);
  grid.per_x = static_cast<float>(grid.columns / (last.x - first.x));
  grid.per_y = static_cast<float>(grid.rows / (last.y - first.y));
}

PlanePoint node_place(const PlaceGrid& grid, double column, double row) {
  return {double{grid.first_x} + column / double{grid.per_x},
          double{grid.first_y} + row / double{grid.per_y}};
}

namespace {

/// A bilinear table of an ST map, whose pixels are its nodes; beyond the outermost ones it goes straight on.
class MapTable {
 public:
  MapTable(const images::ImagePixels& map, const FilmPlaces& film) : map_(map), film_(film) {
    const int width = map.size.width, height = map.size.height;
    const double pixels_x = film.width / width, pixels_y = film.height / height;
    beyond_x_ = 1 + static_cast<int>(std::ceil(kPixelsBeyondFilm / pixels_x));
    beyond_y_ = 1 + static_cast<int>(std::ceil(kPixelsBeyondFilm / pixels_y));
    table_.smooth = false;
    table_.grid.columns = width + 2 * beyond_x_ - 1, table_.grid.rows = height + 2 * beyond_y_ - 1;
    span(film, {(0.5 - beyond_x_) * pixels_x, (0.5 - beyond_y_) * pixels_y},
         {(width + beyond_x_ - 0.5) * pixels_x, (height + beyond_y_ - 0.5) * pixels_y}, table_.grid);
  }

  absl::Status fill() {
    const PlaceGrid& grid = table_.grid;
    table_.nodes.reserve(static_cast<std::size_t>(grid.columns + 1) *
                         static_cast<std::size_t>(grid.rows + 1) * DistortionTable::kBilinearNode);
    for (int row = 0; row <= grid.rows; ++row) {
      for (int column = 0; column <= grid.columns; ++column) {
        const PlanePoint place = node_place(grid, column, row);
        const PlanePoint seen = seen_from(column - beyond_x_, row - beyond_y_);
        if (!std::isfinite(seen.x + seen.y)) {
          return absl::InvalidArgumentError(
              absl::StrCat("camera: its distortion map has no finite number at pixel (", column - beyond_x_,
                           ", ", row - beyond_y_, ")"));
        }
        table_.nodes.push_back(static_cast<float>(seen.x - place.x));
        table_.nodes.push_back(static_cast<float>(seen.y - place.y));
      }
    }
    return check_folds();
  }

  DistortionTable take() { return std::move(table_); }

 private:
  /// The place that a pixel of the map says; pixels beyond it by the two that are next to them.
  PlanePoint seen_from(int column, int row) const {
    const Split x = split(column, map_.size.width), y = split(row, map_.size.height);
    PlanePoint sum;
    for (const int down : {0, 1}) {
      for (const int right : {0, 1}) {
        const double weight = (right == 0 ? 1.0 - x.part : x.part) * (down == 0 ? 1.0 - y.part : y.part);
        if (weight == 0) continue;
        const PlanePoint corner = pixel(x.first + right, y.first + down);
        sum = {sum.x + weight * corner.x, sum.y + weight * corner.y};
      }
    }
    return sum;
  }

  /// The first of the two pixels that a place is counted by, and its distance from it.
  struct Split {
    int first, part;
  };
  static Split split(int at, int size) {
    const int first = std::clamp(at, 0, std::max(size - 2, 0));
    return {first, size > 1 ? at - first : 0};
  }

  PlanePoint pixel(int x, int y) const {
    const std::size_t at = 4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(map_.size.width) +
                                static_cast<std::size_t>(x));
    return film_.at_pixel(double{map_.floats[at]} * film_.width,
                          (1 - double{map_.floats[at + 1]}) * film_.height);
  }

  /// The area of a bilinear cell has its extremes at the corners. Cells beyond the film may fold.
  absl::Status check_folds() const {
    const PlaceGrid& grid = table_.grid;
    const double side = double{grid.per_x} * double{grid.per_y} < 0 ? -1 : 1;
    const auto seen = [&](int column, int row) {
      const PlanePoint place = node_place(grid, column, row);
      const std::size_t at = static_cast<std::size_t>(row) * static_cast<std::size_t>(grid.columns + 1) +
                             static_cast<std::size_t>(column);
      return PlanePoint{place.x + double{table_.nodes[2 * at]}, place.y + double{table_.nodes[2 * at + 1]}};
    };
    for (int row = beyond_y_ - 1; row < grid.rows + 1 - beyond_y_; ++row) {
      for (int column = beyond_x_ - 1; column < grid.columns + 1 - beyond_x_; ++column) {
        const PlanePoint a = seen(column, row), b = seen(column + 1, row), c = seen(column, row + 1),
                         d = seen(column + 1, row + 1);
        const auto turns = [&](PlanePoint x0, PlanePoint x1, PlanePoint y0, PlanePoint y1) {
          return side * ((x1.x - x0.x) * (y1.y - y0.y) - (x1.y - x0.y) * (y1.x - y0.x)) > 0;
        };
        if (!(turns(a, b, a, c) && turns(a, b, b, d) && turns(c, d, a, c) && turns(c, d, b, d))) {
          return folds_at(film_, node_place(grid, column + 0.5, row + 0.5),
                          " (maps of 16-bit floats may have too few digits)");
        }
      }
    }
    return absl::OkStatus();
  }

  const images::ImagePixels& map_;
  const FilmPlaces& film_;
  int beyond_x_ = 1, beyond_y_ = 1;
  DistortionTable table_;
};

absl::StatusOr<DistortionTable> table_of_map(const v1::DistortionMap& message, const FilmPlaces& film,
                                             const BlobSource& blobs) {
  const std::string where = absl::StrCat("camera: its distortion map '", message.image().path(), "'");
  if (!blobs) return absl::InvalidArgumentError(absl::StrCat(where, " is not at hand"));
  const auto bytes = blobs(message.image().digest());
  if (!bytes.ok()) return located(bytes.status(), where);
  const auto map = images::decode_image(bytes->bytes, message.image().path());
  if (!map.ok()) return located(map.status(), where);
  if (!map->floating_point)
    return absl::InvalidArgumentError(absl::StrCat(where, " has integers, not floats"));
  // The rounded height of an image of another size still has the film's proportions.
  const double height = map->size.width * film.height / film.width;
  if (std::abs(map->size.height - height) > 1) {
    return absl::InvalidArgumentError(
        absl::StrFormat("%s has %d x %d pixels, which are not of the film's proportions (%.0f x %.0f)", where,
                        map->size.width, map->size.height, film.width, film.height));
  }
  MapTable table(*map, film);
  if (auto s = table.fill(); !s.ok()) return s;
  return table.take();
}

absl::Status check_camera_kind(const v1::Camera& camera) {
  const v1::LensDistortion& distortion = camera.distortion();
  const bool is_equidistant =
      camera.has_fisheye() && camera.fisheye().mapping() == v1::FisheyeCamera::EQUIDISTANT;
  switch (distortion.kind_case()) {
    case v1::LensDistortion::kOpencv:
      if (camera.has_perspective()) return absl::OkStatus();
      return absl::InvalidArgumentError(
          "camera: opencv is the distortion of a perspective camera; fisheyes have opencv_fisheye");
    case v1::LensDistortion::kOpencvFisheye:
    case v1::LensDistortion::kPolynomial:
      if (is_equidistant) return absl::OkStatus();
      return absl::InvalidArgumentError(
          absl::StrCat("camera: ", distortion.has_polynomial() ? "polynomial" : "opencv_fisheye",
                       " is the distortion of a fisheye of mapping EQUIDISTANT"));
    case v1::LensDistortion::kMap:
      if (camera.has_perspective() || camera.has_orthographic() || camera.has_fisheye())
        return absl::OkStatus();
      return absl::InvalidArgumentError(
          "camera: a distortion map is of perspective and orthographic cameras, and of fisheyes");
    default:
      return absl::InvalidArgumentError("camera: its distortion has no kind, or one that is unknown");
  }
}

}  // namespace

absl::StatusOr<std::shared_ptr<const DistortionTable>> distortion_table(const v1::Camera& camera,
                                                                        const SensorRecord& sensor,
                                                                        const BlobSource& blobs) {
  if (auto s = check_camera_kind(camera); !s.ok()) return s;
  const v1::LensDistortion& distortion = camera.distortion();
  if (distortion.has_polynomial() && distortion.polynomial().angle().empty())
    return absl::InvalidArgumentError("camera: its distortion's polynomial has no coefficients");
  const FilmPlaces film(sensor);
  auto table = distortion.has_map() ? table_of_map(distortion.map(), film, blobs)
                                    : table_of_model(*distortion_model(distortion), film);
  if (!table.ok()) return table.status();
  table->near = static_cast<float>(1e-3 * std::min(std::abs(film.scale_x), std::abs(film.scale_y)));
  if (auto s = add_starts(*table); !s.ok()) return s;
  return std::make_shared<const DistortionTable>(*std::move(table));
}

}  // namespace tessera::render
