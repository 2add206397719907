// Lenses in Zemax's text format (.zmx).
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "optics/prescription.h"

namespace tessera::optics {

struct ZemaxLens {
  Prescription lens;
  double f_number = 0;               // that it was designed for; 0: the file has none
  std::vector<std::string> ignored;  // operands that change what the lens is, and are not read
};

/// Reads a sequential lens: SURF with CURV, DISZ, GLAS, DIAM, STOP, CONI, PARM, of the types STANDARD and
/// EVENASPH; NAME, UNIT, ENPD and FNUM. The first surface is the object and the last one the film. Glass is
/// looked up by name (spectra::find_dispersion), else made from the index and Abbe number that the file has.
/// UTF-8 and UTF-16. Appends all faults of the text to `faults`.
ZemaxLens read_zemax_lens(std::string_view bytes, std::vector<Fault>& faults);

}  // namespace tessera::optics
