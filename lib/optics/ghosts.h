// Ghosts: light that two surfaces of a lens reflect, so that it goes the way between them three times.
#pragma once

#include <cstddef>
#include <vector>

#include "optics/lens_system.h"

namespace tessera::optics {

/// The ghost of a point of light on the axis, as far away as what is sharp.
struct Ghost {
  Bounce bounce;
  double focus = 0;  // along the axis from the film to where rays near to the axis meet; above 0 towards the
                     // lens; infinity: they are parallel
  double part = 0;   // its light over that of the sharp image
  double diameter = 0;  // of the patch of light on the film
};

/// Those of all pairs of surfaces that reflect, the brightest on the film (by light over area) first; none of
/// pairs whose light ends within the lens.
std::vector<Ghost> ghosts_of(const LensSystem& lens, double nm = kLineD);

/// Light that each bounce brings to a film of this half diagonal, over what comes without any, where the
/// scene has the same radiance everywhere: an estimate by some rays. In the order of `bounces`.
std::vector<double> ghost_shares(const LensSystem& lens, const std::vector<Bounce>& bounces,
                                 double half_diagonal, double nm);

}  // namespace tessera::optics
