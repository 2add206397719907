#include "spectra/upsampling/fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "spectra/color/rgb_space.h"
#include "spectra/curve.h"
#include "spectra/light/daylight.h"
#include "spectra/observer/cie1931.h"
#include "spectra/upsampling/sigmoid.h"

namespace tessera::spectra {
namespace {

/// Two wavelengths of Gauss and Legendre between every two of the observer's, as t of SigmoidCoefficients,
/// and their shares in R, G and B of a reflectance under D65.
struct FitSamples {
  static constexpr std::size_t kCount = 2 * (kCieCount - 1);
  std::array<double, kCount> t;
  std::array<std::array<double, kCount>, 3> shares;

  FitSamples() {
    const Matrix3 rgb_of_xyz = rgb_from_xyz(kRec709);
    const Curve light = illuminant_d65();
    const double offset = 0.5 / std::numbers::sqrt3;
    Triple sums = {0, 0, 0};
    for (std::size_t i = 0; i < kCount; ++i) {
      const double row = static_cast<double>(i / 2) + 0.5 + (i % 2 == 0 ? -offset : offset);
      const double nm = kCieFirstNm + kCieStepNm * row;
      t[i] = (nm - double{kSigmoidMiddleNm}) / double{kSigmoidHalfWidthNm};
      const Triple rgb = times(rgb_of_xyz, cie1931().at(nm));
      for (std::size_t c = 0; c < 3; ++c) sums[c] += shares[c][i] = rgb[c] * light.at(nm);
    }
    for (std::size_t c = 0; c < 3; ++c) {
      for (double& share : shares[c]) share /= sums[c];
    }
  }
};

/// The C library's differs from machine to machine. For numbers from 0.005 to 2.
double cube_root(double number) {
  double root = 0.4 + 0.6 * number;
  for (int i = 0; i < 8; ++i) root = (2 * root + number / (root * root)) / 3;
  return root;
}

/// Lab of linear Rec.709, with derivatives: row a has those of L*, a* or b* by R, G and B.
struct LabOfRgb {
  Triple lab;
  Matrix3 by_rgb;
};

LabOfRgb lab_of_rgb(const Triple& rgb) {
  static const Matrix3 to_xyz = xyz_from_rgb(kRec709);
  static const Triple white = times(to_xyz, {1, 1, 1});
  constexpr double kDelta = 6.0 / 29;
  const Triple xyz = times(to_xyz, rgb);
  Triple f, slope;
  for (std::size_t i = 0; i < 3; ++i) {
    const double t = xyz[i] / white[i];
    const bool bright = t > kDelta * kDelta * kDelta;
    f[i] = bright ? cube_root(t) : t / (3 * kDelta * kDelta) + 4.0 / 29;
    slope[i] = (bright ? 1 / (3 * f[i] * f[i]) : 1 / (3 * kDelta * kDelta)) / white[i];
  }
  LabOfRgb result;
  result.lab = {116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])};
  for (std::size_t c = 0; c < 3; ++c) {
    const double x = slope[0] * to_xyz[0][c], y = slope[1] * to_xyz[1][c], z = slope[2] * to_xyz[2][c];
    result.by_rgb[0][c] = 116 * y;
    result.by_rgb[1][c] = 500 * (x - y);
    result.by_rgb[2][c] = 200 * (y - z);
  }
  return result;
}

/// The difference in Lab between a sigmoid and the colour sought, with derivatives by the coefficients.
struct Residual {
  Triple lab;
  Matrix3 by_coefficient;
  double square;
};

Residual residual_of(const Triple& coefficients, const Triple& lab_sought) {
  static const FitSamples samples;
  Triple rgb{};
  Matrix3 rgb_by_coefficient{};
  for (std::size_t i = 0; i < FitSamples::kCount; ++i) {
    const double t = samples.t[i], x = (coefficients[0] * t + coefficients[1]) * t + coefficients[2];
    const double inverse_root = 1 / std::sqrt(1 + x * x);
    const double value = 0.5 + 0.5 * x * inverse_root;
    const double slope = 0.5 * inverse_root * inverse_root * inverse_root;
    for (std::size_t c = 0; c < 3; ++c) {
      const double share = samples.shares[c][i], change = share * slope;
      rgb[c] += share * value;
      rgb_by_coefficient[c][0] += change * t * t;
      rgb_by_coefficient[c][1] += change * t;
      rgb_by_coefficient[c][2] += change;
    }
  }
  const LabOfRgb lab = lab_of_rgb(rgb);
  Residual residual;
  residual.square = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    residual.lab[i] = lab.lab[i] - lab_sought[i];
    residual.square += residual.lab[i] * residual.lab[i];
  }
  residual.by_coefficient = product(lab.by_rgb, rgb_by_coefficient);
  return residual;
}

/// The step of Levenberg and Marquardt: damping 0 is that of Gauss and Newton.
Triple step_of(const Residual& residual, double damping) {
  Matrix3 normal{};
  Triple gradient{};
  const Matrix3& j = residual.by_coefficient;
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t i = 0; i < 3; ++i) gradient[r] += j[i][r] * residual.lab[i];
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::size_t i = 0; i < 3; ++i) normal[r][c] += j[i][r] * j[i][c];
    }
  }
  for (std::size_t i = 0; i < 3; ++i) normal[i][i] *= 1 + damping;
  return times(inverse(normal), gradient);
}

}  // namespace

SigmoidFit fit_sigmoid(const Triple& rgb, const Triple& start) {
  constexpr int kMostSteps = 200;
  constexpr double kNear = 1e-10, kLargest = 1e4;
  const Triple lab = lab_of_rgb(rgb).lab;
  Triple best = start;
  Residual residual = residual_of(best, lab);
  double damping = 1e-3;
  for (int i = 0; i < kMostSteps && residual.square > kNear && damping < 1e12; ++i) {
    const Triple step = step_of(residual, damping);
    Triple next;
    for (std::size_t c = 0; c < 3; ++c) next[c] = std::clamp(best[c] - step[c], -kLargest, kLargest);
    const Residual there = residual_of(next, lab);
    if (there.square < residual.square) {
      best = next;
      residual = there;
      damping = std::max(damping * 0.1, 1e-12);
    } else {
      damping *= 10;
    }
  }
  return {best, std::sqrt(residual.square)};
}

}  // namespace tessera::spectra
