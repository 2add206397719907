// Fitting a sigmoid to a colour.
#pragma once

#include "spectra/observer/observer.h"

namespace tessera::spectra {

/// Coefficients as in SigmoidCoefficients, and how far off they are.
struct SigmoidFit {
  Triple coefficients;
  /// Distance in CIE Lab of 1976 between the colour and that of the fit, under D65 by the CIE 1931 observer.
  double lab_distance;
};

/// The sigmoid that has the colour `rgb` in linear Rec.709 under D65, sought from `start` [Jakob & Hanika
/// 2019]. Components are in [-1, 2]; where they are not in [0, 1], there may be none, and the fit is the
/// nearest that was found.
SigmoidFit fit_sigmoid(const Triple& rgb, const Triple& start);

}  // namespace tessera::spectra
