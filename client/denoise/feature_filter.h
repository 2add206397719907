// Features of what is seen, without their noise.
#pragma once

#include <vector>

#include "denoise/plane.h"

namespace tessera::client::denoise {

/// NL-means with the features' own variance [Rousselle et al. 2013]: one to three planes of one kind, and the
/// variances of their means.
std::vector<Plane> filter_features(const std::vector<Plane>& features, const std::vector<Plane>& variances,
                                   const Plane& inside, int threads);

}  // namespace tessera::client::denoise
