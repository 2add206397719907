// The input of a denoiser: the picture in two halves, how noisy it is, and what is seen where.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "denoise/kernel/kernel.h"
#include "denoise/plane.h"
#include "image/image.h"

namespace tessera::client::denoise {

struct NoisyPicture {
  int width = 0, height = 0;
  // Means of the two halves of each pixel's samples, R, G and B; those of lone fireflies are cut down.
  std::array<Plane, 3> first, second;
  std::array<Plane, 3> variance;  // variance of a half's mean
  std::array<Plane, 3> usual;     // its mean over those of 3 x 3 pixels that show alike things
  Plane inside;                   // 1 in the picture, 0 in its margin
  std::vector<Plane> guides;      // albedo, normal and the logarithm of depth, with their noise filtered out
  std::size_t fireflies = 0, not_finite = 0;  // pixels
};

/// Differences of guides at which pixels have little to do with each other: albedo, normal, logarithm of
/// depth.
inline constexpr float kGuideScale[] = {0.05f, 0.05f, 0.05f, 0.2f, 0.2f, 0.2f, 0.2f};

PlaneView view(const Plane& plane);
/// To be filled in.
template <class Planes>
void set_views(const Planes& planes, PlaneView* views) {
  for (std::size_t i = 0; i < planes.size(); ++i) views[i] = view(planes[i]);
}

/// Reads the channels `prefix`R, G and B, variance, half.*, albedo, normal and depth. InvalidArgument names
/// the AOVs that are missing, or says that single samples have no halves.
absl::StatusOr<NoisyPicture> read_noisy_picture(const Image& image, const std::string& prefix, int threads);

}  // namespace tessera::client::denoise
