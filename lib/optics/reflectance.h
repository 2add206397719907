// Reflectance of the surfaces of lenses.
#pragma once

#include <optional>

#include "optics/prescription.h"

namespace tessera::optics {

/// Part of unpolarised light that is reflected where it comes from index `before` and, under this cosine with
/// the normal, to index `behind`: the mean of s and p, by Fresnel's equations, with what goes to and fro
/// within the layer where there is one [Born & Wolf 1999, section 1.6.4]. 1 where it is totally reflected.
double reflectance(double before, double behind, const std::optional<Coating>& coating, double cosine,
                   double nm);

}  // namespace tessera::optics
