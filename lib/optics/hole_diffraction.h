// Diffraction by a round hole: how light of a point falls on a film behind it.
//
// Lengths on the film are in units of the hole's shadow: the radius a of the hole as the point throws it,
// a (1 + f / z), for a film at f behind the hole and a point at z before it. The Fresnel number is
// a^2 (1 / f + 1 / z) over the wavelength: much above 1, the film shows the shadow; much below, Fraunhofer's
// pattern, whose first dark ring has the radius 0.61 / (Fresnel number).
#pragma once

#include <span>
#include <vector>

namespace tessera::optics {

/// Irradiance at `radius` from the middle, over that of the shadow's inside without diffraction, by Lommel's
/// functions [Born & Wolf 1999, section 8.8]. `fresnel_number` > 0.
double hole_irradiance(double fresnel_number, double radius);

/// Part of the light within these radii, which ascend and are above 0. The last one is far outside, where
/// light_beyond_hole() has the rest.
std::vector<double> light_within_hole(double fresnel_number, std::span<const double> radii);

/// Part of the light beyond a radius far outside, waves apart: from 1.5 on, and from 10 over the Fresnel
/// number on, to a hundredth of it.
double light_beyond_hole(double fresnel_number, double radius);

/// Fresnel numbers above which the hole's shadow is as good: less than 0.4 % of the light falls farther out
/// than 1.1 radii. Patterns of larger ones take seconds to compute.
inline constexpr double kMostFresnelNumber = 150;

}  // namespace tessera::optics
