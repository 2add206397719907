// Thermal radiation.
#pragma once

namespace tessera::spectra {

/// Planck's law at a wavelength, relative to its greatest value over all wavelengths, which Wien's
/// displacement law places at h c / (l k T) = 4.9651142 [CODATA 2018]. Wants `kelvin` above 0.
double relative_planck(double nm, double kelvin);

/// Planck's law: spectral radiance in W / (m^2 sr nm). Wants `kelvin` above 0.
double planck(double nm, double kelvin);

}  // namespace tessera::spectra
