// Looked-up pictures as images, and many views in one.
#pragma once

#include <cstdint>

#include "absl/status/statusor.h"
#include "image/image.h"
#include "light_field/interpolate.h"
#include "light_field/light_field.h"

namespace tessera::client {

/// R, G, B, A and `known`, which is 1 where the light field has the ray. Missing pixels are 0 in all five.
Image image_of(const light_field::Picture& picture);
/// One view of the set: R, G, B, A and depth.Z, the distance of what is seen along the ray. InvalidArgument
/// where a tile is damaged.
absl::StatusOr<Image> image_of_view(light_field::LightField& field, std::uint32_t view);

struct QuiltSize {
  std::uint32_t columns = 8, rows = 6;
};
/// Views of a two-plane set from left to right in one picture, as light-field displays read it: the first,
/// the leftmost, is the lower left one, and rows go upwards. Those between the set's cameras are looked up.
/// Each has the size of the set's views. InvalidArgument where the set is no two-plane grid.
absl::StatusOr<light_field::Picture> quilt_of(light_field::LightField& field, const QuiltSize& quilt,
                                              light_field::Interpolation by, int threads);

}  // namespace tessera::client
