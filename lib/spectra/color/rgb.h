// A colour in linear Rec.709, as scenes and renderer hold it.
#pragma once

namespace tessera::spectra {

struct Rgb {
  float r = 0, g = 0, b = 0;
};

}  // namespace tessera::spectra
