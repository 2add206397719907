// Colour-matching functions of the CIE 1931 2-degree standard observer.
#pragma once

#include <array>

namespace tessera::client {

/// x, y and z at a wavelength, linear between samples 5 nm apart; zero outside 360..830 nm.
std::array<double, 3> cie1931(double wavelength_nm);

}  // namespace tessera::client
