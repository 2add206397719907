#include "spectra/curve.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "absl/strings/str_cat.h"

namespace tessera::spectra {

double Curve::at(double wavelength_nm) const {
  const std::size_t count = std::min(nm.size(), values.size());
  if (count == 0) return 0;
  const auto end = nm.begin() + static_cast<std::ptrdiff_t>(count);
  const auto upper = static_cast<std::size_t>(
      std::upper_bound(nm.begin(), end, static_cast<float>(wavelength_nm)) - nm.begin());
  if (upper == 0) return values[0];
  if (upper == count) return values[count - 1];
  const double t = (wavelength_nm - nm[upper - 1]) / (double{nm[upper]} - nm[upper - 1]);
  return values[upper - 1] + std::clamp(t, 0.0, 1.0) * (double{values[upper]} - values[upper - 1]);
}

Curve uniform_curve(float first_nm, float step_nm, std::span<const float> values) {
  Curve curve;
  curve.values.assign(values.begin(), values.end());
  for (std::size_t i = 0; i < values.size(); ++i)
    curve.nm.push_back(first_nm + step_nm * static_cast<float>(i));
  return curve;
}

void add_zero_ends(Curve& curve, float first_nm, float last_nm) {
  // With room to spare at these wavelengths.
  constexpr float kStepNm = 0.01f;
  if (curve.nm.front() > first_nm) {
    curve.nm.insert(curve.nm.begin(), curve.nm.front() - kStepNm);
    curve.values.insert(curve.values.begin(), 0);
  }
  if (curve.nm.back() < last_nm) {
    curve.nm.push_back(curve.nm.back() + kStepNm);
    curve.values.push_back(0);
  }
}

absl::Status check_curve(const Curve& curve) {
  if (curve.nm.size() != curve.values.size()) {
    return absl::InvalidArgumentError(absl::StrCat("a spectrum needs one value a wavelength, but has ",
                                                   curve.nm.size(), " wavelengths and ", curve.values.size(),
                                                   " values"));
  }
  if (curve.nm.empty())
    return absl::InvalidArgumentError("a spectrum needs one value a wavelength, and at least one");
  for (std::size_t i = 0; i < curve.nm.size(); ++i) {
    if (!std::isfinite(curve.nm[i]))
      return absl::InvalidArgumentError(absl::StrCat("wavelength ", i, " of a spectrum is not finite"));
    if (!std::isfinite(curve.values[i])) {
      return absl::InvalidArgumentError(
          absl::StrCat("the value of a spectrum at ", curve.nm[i], " nm is not finite"));
    }
    if (curve.values[i] < 0) {
      return absl::InvalidArgumentError(absl::StrCat("the value of a spectrum at ", curve.nm[i], " nm is ",
                                                     curve.values[i], ", which is negative"));
    }
    if (i > 0 && !(curve.nm[i] > curve.nm[i - 1])) {
      return absl::InvalidArgumentError(absl::StrCat("wavelengths of a spectrum must ascend, but ",
                                                     curve.nm[i], " nm follows ", curve.nm[i - 1], " nm"));
    }
  }
  constexpr float kFirstNm = 300, kLastNm = 1000;
  if (curve.nm.back() < kFirstNm || curve.nm.front() > kLastNm) {
    return absl::InvalidArgumentError(absl::StrCat("a spectrum has wavelengths from ", curve.nm.front(),
                                                   " to ", curve.nm.back(), " nm, and none from ", kFirstNm,
                                                   " to ", kLastNm, " nm"));
  }
  return absl::OkStatus();
}

}  // namespace tessera::spectra
