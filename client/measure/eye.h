// Meters that read pictures: glare at an eye, and the radiance of parts of the scene's picture.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "measure/measured.h"
#include "tessera/v1/meter.pb.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::client {

struct PictureJob {
  v1::Camera camera;
  std::uint32_t width = 1, height = 1, spp = 1;
  std::uint64_t seed = 0;
};
/// The luminances (of linear Rec.709) of a picture's pixels, rows from the top.
using RenderPicture = std::function<absl::StatusOr<std::vector<double>>(const PictureJob& job)>;

struct PictureSampling {
  std::uint64_t samples = 4096;  // of a part of a picture; a pixel of a fisheye takes a 32nd of them
  std::uint64_t seed = 0;
  double cd_per_m2 = 683;  // luminance of a radiance of 1
};

/// Rates the glare that an eye meets: meters of one figure each. InvalidArgument where it looks nowhere.
absl::StatusOr<std::vector<MeasuredMeter>> measure_glare(const v1::GlareMeter& meter, const std::string& name,
                                                         bool y_up, const PictureSampling& sampling,
                                                         const RenderPicture& render);

/// Measures the mean radiance of a part of the picture of `scene`'s camera, times `factor`. InvalidArgument
/// where it is no part of the picture, or the camera sees all around.
absl::StatusOr<Figure> measure_area(const v1::RadianceMeter::PictureArea& area, const v1::Scene& scene,
                                    double factor, const PictureSampling& sampling,
                                    const RenderPicture& render);

}  // namespace tessera::client
