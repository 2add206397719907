// Sampled spectra: reflectances, illuminants, indices of refraction, whatever is measured over wavelengths.
#pragma once

#include <span>
#include <vector>

#include "absl/status/status.h"

namespace tessera::spectra {

/// A function of the wavelength, piecewise linear and constant beyond its ends. Wavelengths ascend, in
/// nanometres; there is one value for each. An empty curve is zero. Two values at one wavelength are a step.
struct Curve {
  std::vector<float> nm;
  std::vector<float> values;

  double at(double wavelength_nm) const;
};

/// `values` at first, first + step, ... nanometres.
Curve uniform_curve(float first_nm, float step_nm, std::span<const float> values);

/// Makes a curve 0 beyond its ends, where they lie within the range, by steps as steep as floats allow. Needs
/// at least one sample.
void add_zero_ends(Curve& curve, float first_nm, float last_nm);

/// InvalidArgument for a curve that is empty, whose wavelengths and values do not pair up or are not finite,
/// whose wavelengths do not strictly ascend or are all beyond what is seen (in micrometres, perhaps), or that
/// is negative somewhere; the message names the sample.
absl::Status check_curve(const Curve& curve);

}  // namespace tessera::spectra
