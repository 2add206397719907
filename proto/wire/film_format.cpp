#include "wire/film_format.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "absl/strings/str_cat.h"

namespace tessera::wire {

namespace {

constexpr double kFullFrameMm = 43.266615;  // 36 mm x 24 mm
constexpr double kLeastFilmMm = 1e-3, kMostFilmMm = 1e5;

}  // namespace

optics::FilmSize film_size(double diagonal_mm, const std::string& gauge, PictureSize picture) {
  if (const auto* const named = optics::find_film_gauge(gauge))
    return optics::picture_on(named->frame, picture.width / picture.height);
  const double diagonal = diagonal_mm > 0 ? diagonal_mm : kFullFrameMm;
  const double pixels = std::hypot(picture.width, picture.height);
  return {diagonal * picture.width / pixels, diagonal * picture.height / pixels};
}

std::optional<std::string> film_fault(double diagonal_mm, const std::string& gauge) {
  if (!gauge.empty()) {
    if (optics::find_film_gauge(gauge) == nullptr) return optics::unknown_film_gauge(gauge);
    if (diagonal_mm != 0)
      return absl::StrCat("a film of gauge '", gauge, "' has no diagonal of its own, ", diagonal_mm, " mm");
  }
  if (diagonal_mm == 0 || (diagonal_mm >= kLeastFilmMm && diagonal_mm <= kMostFilmMm)) return std::nullopt;
  return absl::StrCat("a film of ", diagonal_mm, " mm is none; ", kLeastFilmMm, " to ", kMostFilmMm,
                      " mm are possible");
}

std::optional<std::string> field_fault(const v1::PerspectiveCamera& camera) {
  const double fov = camera.fov_degrees(), focal_length = camera.focal_length_mm();
  if (focal_length == 0) {
    if (!camera.film_gauge().empty())
      return absl::StrCat("a film gauge '", camera.film_gauge(), "' says nothing without a focal_length_mm");
    if (fov > 0 && fov < 180) return std::nullopt;
    return absl::StrCat("a field of view of ", fov, " degrees is not in (0, 180)");
  }
  if (fov != 0) return "it has a focal_length_mm and fov_degrees, which say the same";
  if (!(focal_length >= kLeastFilmMm && focal_length <= kMostFilmMm))
    return absl::StrCat("a focal length of ", focal_length, " mm is not possible; ", kLeastFilmMm, " to ",
                        kMostFilmMm, " mm are");
  return film_fault(0, camera.film_gauge());
}

double field_of_view(const v1::PerspectiveCamera& camera, PictureSize picture) {
  if (camera.focal_length_mm() == 0) return camera.fov_degrees();
  const optics::FilmSize film =
      film_size(0, camera.film_gauge().empty() ? "full-frame" : camera.film_gauge(), picture);
  const double half = std::min(film.width, film.height) / 2;
  return 2 * std::atan(half / camera.focal_length_mm()) * 180 / std::numbers::pi;
}

void keep_film_scale(PictureSize picture, PictureSize wider, v1::Camera& camera) {
  // The screen window counts in halves of the film's shorter side.
  const auto keep = [&](auto& with_film) {
    const optics::FilmSize film = film_size(with_film, picture);
    with_film.clear_film_gauge();
    with_film.set_film_diagonal_mm(std::min(film.width, film.height) * std::hypot(wider.width, wider.height) /
                                   std::min(wider.width, wider.height));
  };
  if (camera.has_lens()) keep(*camera.mutable_lens());
  if (camera.has_pinhole()) keep(*camera.mutable_pinhole());
  if (camera.perspective().focal_length_mm() == 0) return;
  v1::PerspectiveCamera& perspective = *camera.mutable_perspective();
  perspective.set_fov_degrees(static_cast<float>(field_of_view(perspective, picture)));
  perspective.clear_focal_length_mm();
  perspective.clear_film_gauge();
}

}  // namespace tessera::wire
