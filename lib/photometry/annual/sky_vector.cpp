#include "photometry/annual/sky_vector.h"

namespace tessera::photometry {
namespace {

/// Points along each side of a patch, and of one near the sun.
constexpr int kPatchSteps = 3, kFinePatchSteps = 8;
constexpr double kFineDegrees = 15;

double mean_luminance(const Sky& sky, const SkyPatch& patch) {
  const bool fine = angle_between(patch.middle(), sky.sun) < kFineDegrees * kRadiansPerDegree;
  const int steps = fine ? kFinePatchSteps : kPatchSteps;
  double sum = 0;
  for (int j = 0; j < steps; ++j) {
    for (int i = 0; i < steps; ++i) sum += luminance(sky, patch.at((i + 0.5) / steps, (j + 0.5) / steps));
  }
  return sum / (steps * steps);
}

}  // namespace

std::vector<double> sun_vector(const SkyPatches& patches, const Sky& sky, SunPlacement placement) {
  std::vector<double> vector(patches.size(), 0.0);
  if (placement == SunPlacement::kNone || !(sky.sun_normal_illuminance > 0) || !(sky.sun.up > 0))
    return vector;
  if (placement == SunPlacement::kOwnPatch) {
    const std::size_t number = patches.number_of(sky.sun);
    vector[number] = sky.sun_normal_illuminance / patches.sky(number).solid_angle();
    return vector;
  }
  const std::vector<std::size_t> nearest = patches.nearest(sky.sun, 4);
  const auto weight = [&](std::size_t number) {
    return 1 / (1.002 - cosine_between(patches.sky(number).middle(), sky.sun));
  };
  double total = 0;
  for (const std::size_t number : nearest) total += weight(number);
  for (const std::size_t number : nearest)
    vector[number] = sky.sun_normal_illuminance * weight(number) / total / patches.sky(number).solid_angle();
  return vector;
}

std::vector<double> sky_vector(const SkyPatches& patches, const Sky& sky, SunPlacement placement) {
  std::vector<double> vector = sun_vector(patches, sky, placement);
  std::vector<double> means(patches.size(), 0.0);
  double lit = 0;
  for (std::size_t number = 1; number < patches.size(); ++number) {
    means[number] = mean_luminance(sky, patches.sky(number));
    lit += means[number] * patches.sky(number).horizontal_integral();
  }
  const double scale = lit > 0 ? diffuse_horizontal_illuminance(sky) / lit : 0;
  for (std::size_t number = 1; number < patches.size(); ++number) vector[number] += means[number] * scale;
  vector[0] = sky.ground_luminance;
  return vector;
}

}  // namespace tessera::photometry
