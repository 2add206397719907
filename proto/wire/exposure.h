// How radiance becomes the number of a pixel: a factor, or what photographers set.
#pragma once

#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "tessera/v1/camera.pb.h"

namespace tessera::wire {

struct FilmExposure {
  double factor = 1;
  std::optional<v1::PhotographicExposure> photographic;
};

/// That of the film, as the words of a job's setting `exposure` change it: none, "scene", and stops alone
/// leave it as it is; others take its place, but for what luminance a radiance of 1 has. InvalidArgument,
/// with all that is wrong, for words that mean nothing and numbers that are not possible.
absl::StatusOr<FilmExposure> film_exposure(const v1::Film& film, const std::string& words);

/// InvalidArgument for words that mean nothing.
absl::Status check_exposure_words(const std::string& words);

/// Factor of the pixels of a camera by an exposure. Photographic exposures are relative to ISO 12232's
/// standard output sensitivity: a pixel is 0.18 where the film gets 10 / S lux seconds at ISO speed S.
/// InvalidArgument where the camera's lens does not tell how much light it lets through.
absl::StatusOr<double> exposure_scale(const FilmExposure& exposure, const v1::Camera& camera);

/// Whether pixels are the irradiance of the film, in place of radiance.
bool is_irradiance(const v1::Camera& camera);

/// Light that a lens or a hole lets through.
struct LightThroughLens {
  double irradiance = 0;    // in the middle of the film, by a radiance of 1 all over the scene; steradians
  double transmission = 1;  // part of it that is left by the surfaces of a real lens, at line d
};
/// Nothing where the camera has neither, or one that is not possible.
std::optional<LightThroughLens> lens_light(const v1::Camera& camera);

}  // namespace tessera::wire
