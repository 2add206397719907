// Dispersion formulas of transparent materials.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tessera::spectra {

/// Index of refraction by a formula, within the wavelengths that it was fitted to.
struct Dispersion {
  enum class Formula {
    /// n^2 = 1 + sum of b l^2 / (l^2 - c), with l in micrometres.
    kSellmeier,
    /// n = sum of b l^-c, with l in micrometres.
    kCauchy,
  };
  struct Term {
    double b = 0, c = 0;
  };

  std::string_view name;
  Formula formula;
  std::array<Term, 4> terms;
  double first_nm, last_nm;
  std::string_view source;

  /// Index at a wavelength in nanometres; beyond the range of the fit, that at its end.
  double eta(double nm) const;
};

/// Schott's "N-BK7", "N-BAF10", "N-FK51A", "N-LASF9", "N-SF11", "F2", "F5", "SF5", "SF10", "SF11", and
/// "fused silica", "sapphire" (ordinary ray), "diamond", "water", "ethanol".
std::optional<Dispersion> find_dispersion(std::string_view name);
/// All of these names.
std::vector<std::string> dispersion_names();

/// Cauchy's formula with the terms b + c / l^2 + d / l^4, l in micrometres.
Dispersion cauchy_dispersion(double b, double c, double d);
/// Cauchy's formula with two terms, which has the index `n_d` at the Fraunhofer line d (587.56 nm), and this
/// Abbe number: (n_d - 1) / (n_F - n_C), the lines F and C being at 486.13 and 656.27 nm.
Dispersion abbe_dispersion(double n_d, double abbe_number);

}  // namespace tessera::spectra
