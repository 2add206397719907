// Measured spectra in scenes of tests, and integrals over wavelengths to hold their pictures against.
#pragma once

#include <functional>
#include <string>

#include "absl/strings/str_cat.h"
#include "spectra/color/rgb_space.h"
#include "spectra/color/tristimulus.h"
#include "spectra/light/daylight.h"
#include "spectra/observer/observer.h"

namespace tessera::test {

/// A v1::Spectrum in text form.
inline std::string message_of(const spectra::Curve& curve) {
  std::string text = "sampled { ";
  for (std::size_t i = 0; i < curve.nm.size(); ++i)
    absl::StrAppend(&text, "wavelengths_nm: ", curve.nm[i], " values: ", curve.values[i], " ");
  return text + "}";
}

/// The integral of f between two wavelengths, by the middles of many small steps.
inline double integral(double from, double to, const std::function<double(double nm)>& f) {
  constexpr int kSteps = 4000;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) sum += f(from + (to - from) * (i + 0.5) / kSteps);
  return sum * (to - from) / kSteps;
}

/// Linear Rec.709 of light that has this part of daylight at a wavelength.
inline spectra::Triple in_daylight(const std::function<double(double nm)>& part) {
  const spectra::Curve daylight = spectra::unit_d65();
  spectra::Curve light;
  for (int nm = 360; nm <= 830; ++nm) {
    light.nm.push_back(static_cast<float>(nm));
    light.values.push_back(static_cast<float>(part(nm) * daylight.at(nm)));
  }
  return spectra::times(spectra::rgb_from_xyz(spectra::kRec709),
                        spectra::tristimulus(light, spectra::cie1931()));
}

}  // namespace tessera::test
