// How strongly light of each wavelength acts on one kind of receptor: single functions of the wavelength.
#pragma once

#include <span>

namespace tessera::spectra {

/// A function tabulated at even steps, linear between them and zero outside; the largest value is 1.
struct ActionSpectrum {
  double first_nm, step_nm;
  std::span<const double> values;

  constexpr double last_nm() const { return first_nm + step_nm * static_cast<double>(values.size() - 1); }
  double at(double wavelength_nm) const;
  /// The integral from one wavelength to another, in nm: exact.
  double integral(double from_nm, double to_nm) const;
};

/// V(lambda), photopic vision: y of the CIE 1931 observer, 360 to 830 nm in steps of 5 nm [CIE 15:2004].
const ActionSpectrum& photopic();

/// V'(lambda), vision in the dark, 380 to 780 nm in steps of 5 nm [CIE 1951; ISO/CIE 23539:2023].
const ActionSpectrum& scotopic();

/// Melanopic action spectrum: ganglion cells that set the body's clock; 380 to 780 nm in steps of 5 nm [CIE S
/// 026:2018].
const ActionSpectrum& melanopic();

}  // namespace tessera::spectra
