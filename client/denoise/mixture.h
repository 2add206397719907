// Several denoised pictures in one.
#pragma once

#include <array>
#include <vector>

#include "denoise/methods.h"
#include "denoise/noisy_picture.h"

namespace tessera::client::denoise {

/// R, G and B.
using Picture = std::array<Plane, 3>;

/// Each half, denoised.
struct Candidate {
  const Picture &first, &second;
};

/// Mixes the candidates and the picture as it is, at each pixel mostly of what has the least error there, as
/// the halves tell it [Rousselle et al. 2012]: a denoised half is held against the other half, whose noise is
/// another.
Colours mixed(const NoisyPicture& picture, std::vector<Candidate> candidates, int threads);

}  // namespace tessera::client::denoise
