#include "spectra/color/tristimulus.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>
#include <vector>

namespace tessera::spectra {
namespace {

/// Wavelengths within the observer's range between which all factors are lines.
class Knots {
 public:
  explicit Knots(const Observer& observer) : first_(observer.first_nm), last_(observer.last_nm()) {
    for (std::size_t i = 0; i < observer.rows.size(); ++i)
      nm_.push_back(observer.first_nm + observer.step_nm * static_cast<double>(i));
  }

  void add(const Curve& curve) {
    for (const float nm : curve.nm) {
      if (nm > first_ && nm < last_) nm_.push_back(nm);
    }
  }

  std::vector<double> sorted() && {
    std::sort(nm_.begin(), nm_.end());
    return std::move(nm_);
  }

 private:
  double first_, last_;
  std::vector<double> nm_;
};

/// The integrals of f times the observer's sensitivities. Two points of Gauss and Legendre in each interval
/// are exact for cubics, the products of three lines, and lie beside the steps at its ends.
template <class F>
Triple integral(const std::vector<double>& knots, const Observer& observer, F&& f) {
  const double offset = 0.5 / std::numbers::sqrt3;
  Triple sums = {0, 0, 0};
  for (std::size_t i = 0; i + 1 < knots.size(); ++i) {
    const double width = knots[i + 1] - knots[i], middle = 0.5 * (knots[i] + knots[i + 1]);
    for (const double nm : {middle - offset * width, middle + offset * width}) {
      const double weight = 0.5 * width * f(nm);
      const Triple sensitivity = observer.at(nm);
      for (std::size_t c = 0; c < 3; ++c) sums[c] += weight * sensitivity[c];
    }
  }
  return sums;
}

Triple scaled(Triple values, double divisor) {
  for (double& value : values) value /= divisor;
  return values;
}

}  // namespace

Triple tristimulus(const Curve& light, const Observer& observer) {
  Knots knots(observer);
  const Triple of_one = integral(Knots(knots).sorted(), observer, [](double) { return 1.0; });
  knots.add(light);
  return scaled(integral(std::move(knots).sorted(), observer, [&](double nm) { return light.at(nm); }),
                of_one[1]);
}

Triple tristimulus(const Curve& reflectance, const Curve& light, const Observer& observer) {
  Knots knots(observer);
  knots.add(light);
  const Triple white = integral(Knots(knots).sorted(), observer, [&](double nm) { return light.at(nm); });
  knots.add(reflectance);
  return scaled(integral(std::move(knots).sorted(), observer,
                         [&](double nm) { return reflectance.at(nm) * light.at(nm); }),
                white[1]);
}

Chromaticity chromaticity(const Triple& xyz) {
  const double sum = xyz[0] + xyz[1] + xyz[2];
  return {xyz[0] / sum, xyz[1] / sum};
}

Triple xyz_of(const Chromaticity& chromaticity) {
  return {chromaticity.x / chromaticity.y, 1, (1 - chromaticity.x - chromaticity.y) / chromaticity.y};
}

}  // namespace tessera::spectra
