// Lens files of pbrt (.dat).
#pragma once

#include <string_view>
#include <vector>

#include "optics/prescription.h"

namespace tessera::optics {

/// Reads a line for each surface from the scene to the film: radius of curvature, thickness, index of
/// refraction behind it, diameter of its aperture; `#` begins a comment. A radius of 0 is the aperture stop
/// (the first one, where there are several), an index of 0 is air. UTF-8 and UTF-16. Appends all faults of
/// the text to `faults`.
Prescription read_pbrt_lens(std::string_view bytes, std::vector<Fault>& faults);

}  // namespace tessera::optics
