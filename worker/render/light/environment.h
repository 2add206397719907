// Making environment lights.
#pragma once

#include "absl/status/statusor.h"
#include "render/color/texture_table.h"
#include "render/light/light_table.h"

namespace tessera::render {

/// An environment from an image, with the distribution that it is sampled by. Radiance is texel times
/// `scale`; negative texels count as zero. An octahedral image is square. The upper left 3x3 of
/// `render_from_light` turns (and may mirror or uniformly scale) directions. `compensate` is for where BSDF
/// sampling finds the light as well, and multiple importance sampling weighs the two: only what is brighter
/// than the mean is sampled then [Karlik et al. 2019], and nothing when that is next to nothing.
/// InvalidArgument says what is wrong with the image or the transform.
absl::StatusOr<Environment> build_environment(TextureImage image, EnvironmentMapping mapping, float scale,
                                              const Affine& render_from_light, bool compensate = false);

/// The error of build_environment() for an image of this size, or OK.
absl::Status check_environment_size(std::int32_t width, std::int32_t height, EnvironmentMapping mapping);

}  // namespace tessera::render
