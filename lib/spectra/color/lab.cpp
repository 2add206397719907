#include "spectra/color/lab.h"

#include <cmath>
#include <numbers>

namespace tessera::spectra {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

double lab_curve(double t) {
  constexpr double kDelta = 6.0 / 29;
  return t > kDelta * kDelta * kDelta ? std::cbrt(t) : t / (3 * kDelta * kDelta) + 4.0 / 29;
}

/// x^7 / (x^7 + 25^7)
double chroma_share(double chroma) {
  const double seventh = std::pow(chroma, 7);
  return seventh / (seventh + 6103515625.0);
}

/// Hue angle in degrees from 0 to 360; 0 for grey.
double hue_of(double a, double b) {
  if (a == 0 && b == 0) return 0;
  const double hue = std::atan2(b, a) / kDegree;
  return hue < 0 ? hue + 360 : hue;
}

double cos_degrees(double angle) { return std::cos(angle * kDegree); }

}  // namespace

Lab lab_of(const Triple& xyz, const Triple& white) {
  const double x = lab_curve(xyz[0] / white[0]), y = lab_curve(xyz[1] / white[1]),
               z = lab_curve(xyz[2] / white[2]);
  return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

double delta_e2000(const Lab& first, const Lab& second) {
  // Greens and blues are stretched along a, near grey most.
  const double mean_chroma = (std::hypot(first.a, first.b) + std::hypot(second.a, second.b)) / 2;
  const double stretch = 1 + 0.5 * (1 - std::sqrt(chroma_share(mean_chroma)));
  const double a1 = stretch * first.a, a2 = stretch * second.a;
  const double c1 = std::hypot(a1, first.b), c2 = std::hypot(a2, second.b);
  const double h1 = hue_of(a1, first.b), h2 = hue_of(a2, second.b);
  // Differences of lightness, chroma and hue.
  const bool grey = c1 * c2 == 0;
  double turn = grey ? 0 : h2 - h1;
  if (turn > 180) turn -= 360;
  if (turn < -180) turn += 360;
  const double dl = second.l - first.l, dc = c2 - c1,
               dh = 2 * std::sqrt(c1 * c2) * std::sin(turn / 2 * kDegree);
  // Means, of hues on the shorter way.
  const double l = (first.l + second.l) / 2, c = (c1 + c2) / 2;
  double h = h1 + h2;
  if (!grey) {
    if (std::abs(h1 - h2) > 180) h += h < 360 ? 360 : -360;
    h /= 2;
  }
  // Weights of the differences there.
  const double t = 1 - 0.17 * cos_degrees(h - 30) + 0.24 * cos_degrees(2 * h) +
                   0.32 * cos_degrees(3 * h + 6) - 0.20 * cos_degrees(4 * h - 63);
  const double off = (l - 50) * (l - 50);
  const double sl = 1 + 0.015 * off / std::sqrt(20 + off), sc = 1 + 0.045 * c, sh = 1 + 0.015 * c * t;
  const double blueness = (h - 275) / 25;
  const double rotation =
      -2 * std::sqrt(chroma_share(c)) * std::sin(60 * std::exp(-blueness * blueness) * kDegree);
  const double x = dl / sl, y = dc / sc, z = dh / sh;
  return std::sqrt(x * x + y * y + z * z + rotation * y * z);
}

}  // namespace tessera::spectra
