// How light that reaches a sensor becomes the channels of its picture; sensor/respond.h computes it.
#pragma once

namespace tessera::render {

/// Linear: a channel is the mean of the radiance over its band, times the exposure.
struct Response {
  float exposure = 1;
};

}  // namespace tessera::render
