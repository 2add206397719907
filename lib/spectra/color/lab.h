// CIE Lab, and differences of colours in it.
#pragma once

#include "spectra/observer/observer.h"

namespace tessera::spectra {

/// CIE 1976 L*, a* and b* [CIE 15:2004].
struct Lab {
  double l, a, b;
};

/// XYZ relative to a white in XYZ.
Lab lab_of(const Triple& xyz, const Triple& white);

/// The difference CIEDE2000 with all weights 1 [Sharma et al. 2005]: 1 is about what can be told apart side
/// by side.
double delta_e2000(const Lab& first, const Lab& second);

}  // namespace tessera::spectra
