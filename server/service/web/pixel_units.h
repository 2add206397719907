// Units of the numbers of a job's picture.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "tessera/v1/job.pb.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::server {

class BlobReader;

/// Luminance of a radiance of 1 W/(m^2 sr) where a scene says nothing else [BIPM2019].
inline constexpr double kUsualCdPerM2 = 683;

struct PixelUnits {
  // Luminance of linear red, green and blue of the picture; 0 where they are a sensor's own.
  std::array<double, 3> weights{};
  double cd_per_m2 = 0;  // luminance of pixels whose weighted sum is 1; 0: they have none
  double radiance = 0;   // the radiance of such pixels, in W/(m^2 sr); 0: it is not known
  std::string about;     // for people: why there is none, or that a default was taken
};

/// Reads camera, film and units of a serialized Scene, and skips all else, in pieces: scenes may be larger
/// than memory. InvalidArgument where it is no scene.
absl::StatusOr<v1::Scene> read_scene_head(const BlobReader& scene);

/// Units of the pixels of a job whose scene has this camera, film and units.
PixelUnits pixel_units_of(const v1::Scene& head, const v1::JobSpec& spec);

/// Those of a job whose scene is not there any more, or cannot be read.
PixelUnits usual_pixel_units(const v1::JobSpec& spec);

}  // namespace tessera::server
