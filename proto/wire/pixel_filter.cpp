#include "wire/pixel_filter.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "wire/algorithm.h"
#include "wire/aov_channels.h"
#include "wire/limits.h"

namespace tessera::wire {
namespace {

float usual_radius(v1::PixelFilter::Kind kind) {
  switch (kind) {
    case v1::PixelFilter::TRIANGLE:
    case v1::PixelFilter::MITCHELL:
      return 2;
    case v1::PixelFilter::GAUSSIAN:
      return 1.5f;
    case v1::PixelFilter::LANCZOS:
      return 4;
    default:
      return 0.5f;
  }
}

// Scattered samples are spread evenly over the pixel, whatever the filter's shape. A filter f of integral 1
// leaves 1 / (the integral of f^2) of their noise's variance: less than that of samples which follow the
// filter only where it is about as wide as a pixel. Halfway to a gain of 2:
constexpr float kLeastRadius = 0.8f;  // a tent's gain is 2.25 r^2
constexpr float kLeastSigma = 0.34f;  // a Gaussian's is 4 pi sigma^2
constexpr float kUsualSigma = 0.5f;

}  // namespace

FilterRadius radius_of(const v1::PixelFilter& filter) {
  const auto or_usual = [&](float radius) {
    return radius > 0 && std::isfinite(radius) ? radius : usual_radius(filter.kind());
  };
  return {or_usual(filter.radius_x()), or_usual(filter.radius_y())};
}

bool gains_by_scattering(const v1::PixelFilter& filter) {
  if (filter.kind() == v1::PixelFilter::BOX) return false;
  const FilterRadius radius = radius_of(filter);
  const float sigma = filter.sigma() > 0 ? filter.sigma() : kUsualSigma;
  if (filter.kind() == v1::PixelFilter::GAUSSIAN && sigma < kLeastSigma) return false;
  return std::min(radius.x, radius.y) >= kLeastRadius && check_scattering(filter).ok();
}

absl::Status check_scattering(const v1::PixelFilter& filter) {
  const FilterRadius radius = radius_of(filter);
  if (std::max(radius.x, radius.y) <= kMaxScatterRadius) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("film: the pixel filter's radius is ", std::max(radius.x, radius.y),
                   "; with reconstruction 'scatter' at most ", kMaxScatterRadius, " was expected"));
}

absl::Status allows_scattering(const v1::JobSpec& spec) {
  const AlgorithmTraits* const algorithm = find_algorithm(spec.content().algorithms().integrator());
  if (algorithm == nullptr || !algorithm->scatters) {
    return absl::InvalidArgumentError(absl::StrCat("integrator '", spec.content().algorithms().integrator(),
                                                   "' has its own way from samples to pixels: reconstruction "
                                                   "'scatter' is not for it"));
  }
  if (spec.view().lens_ghosts() == v1::LENS_GHOSTS_LIGHTS) {
    return absl::InvalidArgumentError(
        "reconstruction 'scatter' does not go with lens_ghosts 'lights', whose samples are of all pixels");
  }
  for (const int aov : spec.view().aovs()) {
    // A list knows whose sample it is; its neighbours' would have to be merged by their weights.
    if (is_cryptomatte(static_cast<v1::AOV>(aov))) {
      return absl::InvalidArgumentError(
          "reconstruction 'scatter' does not go with Cryptomatte: 'sample' gives the filter's coverages");
    }
  }
  return absl::OkStatus();
}

}  // namespace tessera::wire
