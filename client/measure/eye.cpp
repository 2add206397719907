#include "measure/eye.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "absl/strings/str_cat.h"
#include "import/geometry/transform.h"
#include "measure/receivers.h"
#include "photometry/glare/glare_figures.h"
#include "wire/film_format.h"
#include "wire/scene_views.h"

namespace tessera::client {

namespace {

using Imath::V3d;

/// Pictures of other seeds, whose spread tells the error.
constexpr std::size_t kPictures = 8;

/// Directions and solid angles of the pixels of an equisolid fisheye of 180 degrees: all pixels within the
/// circle see the same solid angle.
struct EyePixels {
  std::vector<photometry::ViewDirection> directions;
  std::vector<double> solid_angles;
};
EyePixels eye_pixels(int side) {
  EyePixels eye;
  for (int row = 0; row < side; ++row) {
    for (int column = 0; column < side; ++column) {
      const double x = (column + 0.5) * 2 / side - 1, y = 1 - (row + 0.5) * 2 / side, r = std::hypot(x, y);
      const double angle = 2 * std::asin(std::min(1.0, r * std::numbers::sqrt2 / 2));
      const double across = r > 0 ? std::sin(angle) / r : 0;
      eye.directions.push_back({across * x, across * y, std::cos(angle)});
      eye.solid_angles.push_back(r <= 1 ? 8.0 / side / side : 0);
    }
  }
  return eye;
}

struct GlareFigure {
  const char* name;
  const char* quantity;
  const char* unit;
  double photometry::GlareFigures::*value;
};
constexpr GlareFigure kFigures[] = {
    {"DGP", "daylight glare probability", "1", &photometry::GlareFigures::daylight_glare_probability},
    {"UGR", "unified glare rating", "1", &photometry::GlareFigures::unified_glare_rating},
    {"DGI", "daylight glare index", "1", &photometry::GlareFigures::daylight_glare_index},
    {"at the eye", "vertical illuminance", "lx", &photometry::GlareFigures::vertical_illuminance},
    {"background", "background luminance", "cd/m2", &photometry::GlareFigures::background_luminance},
    {"mean", "mean luminance", "cd/m2", &photometry::GlareFigures::mean_luminance}};

/// Glare of the mean of pictures but for the one left out; kPictures leaves none out.
absl::StatusOr<photometry::GlareFigures> glare_without(const std::vector<std::vector<double>>& pictures,
                                                       std::size_t left_out, int side, const EyePixels& eye,
                                                       double cd_per_m2) {
  std::vector<float> luminances(eye.directions.size());
  const double count = static_cast<double>(pictures.size() - (left_out < pictures.size() ? 1 : 0));
  for (std::size_t i = 0; i < luminances.size(); ++i) {
    double sum = 0;
    for (std::size_t k = 0; k < pictures.size(); ++k) sum += k == left_out ? 0 : pictures[k][i];
    luminances[i] = static_cast<float>(std::max(0.0, cd_per_m2 * sum / count));
  }
  return photometry::glare_of({side, side, luminances, eye.directions, eye.solid_angles});
}

/// The jackknife's standard error of an estimate [Efron 1982], by the estimates without one repetition each.
double jackknife_error(const std::vector<double>& without) {
  double mean = 0, squares = 0;
  const double n = static_cast<double>(without.size());
  for (const double value : without) mean += value / n;
  for (const double value : without) squares += (value - mean) * (value - mean);
  return std::sqrt(squares * (n - 1) / n);
}

}  // namespace

absl::StatusOr<std::vector<MeasuredMeter>> measure_glare(const v1::GlareMeter& meter, const std::string& name,
                                                         bool y_up, const PictureSampling& sampling,
                                                         const RenderPicture& render) {
  constexpr std::uint32_t kUsualSide = 512, kMostSide = 4096;
  const std::uint32_t side = meter.resolution() > 0 ? meter.resolution() : kUsualSide;
  if (side > kMostSide) return absl::InvalidArgumentError("a fisheye has 4096 pixels a side at most");
  const V3d eye = vector_of(meter.eye()), target = vector_of(meter.toward());
  const V3d up = y_up ? V3d(0, 1, 0) : V3d(0, 0, 1);
  const auto camera_from_world = look_at(eye, target, up);
  const auto world_from_camera = camera_from_world ? inverse(*camera_from_world) : std::nullopt;
  if (!world_from_camera) return absl::InvalidArgumentError("the eye looks nowhere, or straight up or down");
  PictureJob job;
  job.camera.mutable_fisheye()->set_mapping(v1::FisheyeCamera::EQUISOLID);
  job.camera.mutable_fisheye()->set_fov_degrees(180);
  job.camera.mutable_fisheye()->set_circle_degrees(180);
  write_matrix(*world_from_camera, *job.camera.mutable_world_from_camera());
  job.width = job.height = side;
  job.spp = static_cast<std::uint32_t>(
      std::bit_floor(std::clamp<std::uint64_t>(sampling.samples / 32 / kPictures, 1, 1024)));
  std::vector<std::vector<double>> pictures;
  for (std::size_t k = 0; k < kPictures; ++k) {
    job.seed = sampling.seed + k;
    auto picture = render(job);
    if (!picture.ok()) return picture.status();
    pictures.push_back(*std::move(picture));
  }
  const EyePixels pixels = eye_pixels(static_cast<int>(side));
  const auto glare = [&](std::size_t left_out) {
    return glare_without(pictures, left_out, static_cast<int>(side), pixels, sampling.cd_per_m2);
  };
  const auto whole = glare(kPictures);
  if (!whole.ok()) return whole.status();
  std::vector<photometry::GlareFigures> without;
  for (std::size_t k = 0; k < kPictures; ++k) {
    auto figures = glare(k);
    if (!figures.ok()) return figures.status();
    without.push_back(*std::move(figures));
  }
  std::vector<MeasuredMeter> result;
  for (const GlareFigure& figure : kFigures) {
    MeasuredMeter& made = result.emplace_back();
    made.name = absl::StrCat(name, ": ", figure.name), made.quantity = figure.quantity,
    made.unit = figure.unit;
    std::vector<double> values;
    for (const photometry::GlareFigures& figures : without) values.push_back(figures.*figure.value);
    const double value = *whole.*figure.value;
    const double error = std::isfinite(value) ? jackknife_error(values) : 0;
    made.readings.push_back({"",
                             eye,
                             (target - eye).normalized(),
                             {value, std::isfinite(error) ? error : std::numeric_limits<double>::infinity(),
                              std::uint64_t{side} * side * job.spp * kPictures, kPictures - 1}});
  }
  if (!whole->found.merged)
    result.front().warnings.emplace_back(
        "the picture has too many bright spots to be merged into sources: it is noisy; more --samples help");
  return result;
}

absl::StatusOr<Figure> measure_area(const v1::RadianceMeter::PictureArea& area, const v1::Scene& scene,
                                    double factor, const PictureSampling& sampling,
                                    const RenderPicture& render) {
  const auto is_part = [](double from, double to) { return from >= 0 && from < to && to <= 1; };
  if (!is_part(area.x0(), area.x1()) || !is_part(area.y0(), area.y1()))
    return absl::InvalidArgumentError(
        "an area of the picture goes from x0 to x1 and y0 to y1, within 0 and 1");
  if (wire::sees_all_around(scene.camera()))
    return absl::InvalidArgumentError("areas are of cameras with a screen: this one sees all around");
  const double width = scene.film().width(), height = scene.film().height();
  float screen[4] = {-1, 1, -1, 1};
  const auto aspect = static_cast<float>(width / height);
  if (scene.camera().screen_window_size() == 4) {
    std::copy_n(scene.camera().screen_window().begin(), 4, screen);
  } else if (aspect > 1) {
    screen[0] = -aspect, screen[1] = aspect;
  } else {
    screen[2] = -1 / aspect, screen[3] = 1 / aspect;
  }
  PictureJob job;
  job.camera = scene.camera();
  // The angle of a lens is that of its film, which is a part of the picture's now.
  wire::keep_film_scale({width, height}, {width * (area.x1() - area.x0()), height * (area.y1() - area.y0())},
                        job.camera);
  job.camera.clear_screen_window();
  const auto at = [](float from, float to, double part) {
    return static_cast<float>(from + (to - from) * part);
  };
  for (const float edge : {at(screen[0], screen[1], area.x0()), at(screen[0], screen[1], area.x1()),
                           at(screen[3], screen[2], area.y1()), at(screen[3], screen[2], area.y0())})
    job.camera.add_screen_window(edge);
  constexpr std::uint32_t kSide = 16;
  job.width = job.height = kSide;
  job.spp = static_cast<std::uint32_t>(
      std::bit_ceil(std::max<std::uint64_t>(1, sampling.samples / kSide / kSide / kPictures)));
  double mean = 0, squares = 0;
  for (std::size_t k = 0; k < kPictures; ++k) {
    job.seed = sampling.seed + k;
    const auto picture = render(job);
    if (!picture.ok()) return picture.status();
    double sum = 0;
    for (const double luminance : *picture) sum += luminance;
    const double value = factor * sum / static_cast<double>(picture->size()), away = value - mean;
    mean += away / static_cast<double>(k + 1);
    squares += away * (value - mean);
  }
  return Figure{mean, std::sqrt(squares / (kPictures - 1) / kPictures),
                std::uint64_t{kSide} * kSide * job.spp * kPictures, kPictures - 1};
}

}  // namespace tessera::client
