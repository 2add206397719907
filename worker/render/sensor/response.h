// How light that reaches a sensor becomes the channels of its picture; sensor/respond.h computes it.
#pragma once

#include "render/color/spectral_tables.h"

namespace tessera::render {

/// Linear: a channel is the mean of the radiance over its band, times the exposure.
struct Response {
  float exposure = 1;
  SensitivityTable sensitivity;  // jobs of wavelengths only
};

}  // namespace tessera::render
