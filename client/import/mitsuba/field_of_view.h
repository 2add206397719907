// Field of view, which perspective sensors and projectors have in common.
#pragma once

#include "import/mitsuba/document/property_reader.h"

namespace tessera::client::mitsuba {

/// Half the width of the picture at distance 1, from `fov` and `fov_axis`, or `focal_length` (50mm where
/// nothing is given). `aspect` is width over height.
double read_half_width(PropertyReader& reader, double aspect);

}  // namespace tessera::client::mitsuba
