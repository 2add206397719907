// Observers and cameras: three sensitivities over wavelengths.
#pragma once

#include <array>
#include <span>

namespace tessera::spectra {

using Triple = std::array<double, 3>;

/// Three functions of the wavelength, tabulated at even steps, linear between them and zero outside.
struct Observer {
  double first_nm, step_nm;
  std::span<const Triple> rows;

  constexpr double last_nm() const { return first_nm + step_nm * static_cast<double>(rows.size() - 1); }
  Triple at(double wavelength_nm) const;
};

/// CIE 1931 2-degree standard observer, 360 to 830 nm in steps of 5 nm: x, y and z [CIE 15:2004, table T.4].
const Observer& cie1931();

/// Cone-fundamental-based 2-degree observer of CIE 2006, 390 to 830 nm in steps of 5 nm: x, y and z [CIE
/// 170-2:2015].
const Observer& cie2006();

/// The same for 10 degrees.
const Observer& cie2006_10();

}  // namespace tessera::spectra
