// Figures over other figures: quotients and contrasts.
#pragma once

#include <cstddef>

#include "measure/measured.h"
#include "tessera/v1/meter.pb.h"

namespace tessera::client {

/// The ratio of two figures whose errors are independent, with the error that follows from theirs to first
/// order. NaN, and no error, where what it is over is 0.
Figure ratio_of(const Figure& of, const Figure& over, v1::RatioMeter::Kind kind);

/// Half of the 95 % interval of such a ratio over all that is added and subtracted in it, as relative_error()
/// has it; 0 where it is exact.
double relative_error_of_ratio(const Figure& ratio, v1::RatioMeter::Kind kind);

/// Number of the figure that figure `number` of `of` is over, of `figures` in all.
inline std::size_t partner_of(std::size_t number, std::size_t figures) { return figures == 1 ? 0 : number; }

}  // namespace tessera::client
