// The size of a camera's film, which messages give by its diagonal or by name.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "optics/film_gauge.h"
#include "tessera/v1/camera.pb.h"

namespace tessera::wire {

/// Pixels of a picture.
struct PictureSize {
  double width = 1, height = 1;
};

/// Millimetres across such a picture, for numbers and names that film_fault() has no objection to: on the
/// film gauge, if there is a name, else of this diagonal, 0 being that of a film of 36 mm x 24 mm.
optics::FilmSize film_size(double diagonal_mm, const std::string& gauge, PictureSize picture);

/// Why there is no such film.
std::optional<std::string> film_fault(double diagonal_mm, const std::string& gauge);

/// Cameras that have a film.
template <class CameraKind>
optics::FilmSize film_size(const CameraKind& camera, PictureSize picture) {
  return film_size(camera.film_diagonal_mm(), camera.film_gauge(), picture);
}

/// Why a perspective camera has no field of view.
std::optional<std::string> field_fault(const v1::PerspectiveCamera& camera);
/// Its field of view across the shorter side of the screen window, degrees: as it is
/// given, or that of its focal length.
double field_of_view(const v1::PerspectiveCamera& camera, PictureSize picture);

/// Says the scale of a camera's film, as it is for `picture`, in fields that keep it on a film of another
/// shape which has the size `wider`.
void keep_film_scale(PictureSize picture, PictureSize wider, v1::Camera& camera);

}  // namespace tessera::wire
