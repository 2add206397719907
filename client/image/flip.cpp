#include "image/flip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "absl/strings/str_cat.h"

namespace tessera::client {
namespace {

constexpr float kPixelsPerDegree = 67;
constexpr double kPi = std::numbers::pi;

using Plane = std::vector<float>;
using Planes = std::array<Plane, 3>;
using Color = std::array<float, 3>;

/// Taps of a filter, the middle one in the middle.
using Taps = std::vector<float>;

Taps gaussian(int radius, double exponent) {
  Taps taps;
  for (int i = -radius; i <= radius; ++i) taps.push_back(static_cast<float>(std::exp(exponent * i * i)));
  return taps;
}

double sum_of(const Taps& taps) {
  double sum = 0;
  for (const float tap : taps) sum += tap;
  return sum;
}

/// Positive taps add up to 1, negative ones to -1.
void balance(Taps& taps) {
  double positive = 0, negative = 0;
  for (const float tap : taps) (tap > 0 ? positive : negative) += tap;
  for (float& tap : taps) tap /= static_cast<float>(tap > 0 ? positive : negative < 0 ? -negative : 1.0);
}

class Convolver {
 public:
  Convolver(int width, int height) : width_(width), height_(height) {}

  /// Rows with `across`, columns with `down`; the border's pixels go on beyond it.
  Plane operator()(const Plane& plane, const Taps& across, const Taps& down) const {
    return pass(pass(plane, across, 1, width_), down, width_, height_);
  }

 private:
  Plane pass(const Plane& plane, const Taps& taps, int step, int length) const {
    const int radius = static_cast<int>(taps.size() / 2);
    Plane out(plane.size());
    for (int i = 0; i < static_cast<int>(plane.size()); ++i) {
      const int at = i / step % length;
      float sum = 0;
      for (int k = -radius; k <= radius; ++k) {
        const int there = std::clamp(at + k, 0, length - 1);
        sum += taps[static_cast<std::size_t>(k + radius)] *
               plane[static_cast<std::size_t>(i + (there - at) * step)];
      }
      out[static_cast<std::size_t>(i)] = sum;
    }
    return out;
  }

  int width_, height_;
};

// Rec.709 with its white (D65).
constexpr float kXyzFromRgb[3][3] = {{0.41238656f, 0.35759149f, 0.18045049f},
                                     {0.21263682f, 0.71518298f, 0.0721802f},
                                     {0.01933062f, 0.11919716f, 0.95037259f}};
constexpr float kRgbFromXyz[3][3] = {{3.24100326f, -1.53739899f, -0.49861587f},
                                     {-0.96922426f, 1.87592999f, 0.04155422f},
                                     {0.05563942f, -0.2040112f, 1.05714897f}};
constexpr Color kWhite{0.95042854f, 1.0f, 1.08890037f};

Color times(const float (&m)[3][3], const Color& v) {
  Color out;
  for (std::size_t i = 0; i < 3; ++i) out[i] = m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2];
  return out;
}

/// XYZ relative to white.
Color relative_xyz(const Color& rgb) {
  Color xyz = times(kXyzFromRgb, rgb);
  for (std::size_t i = 0; i < 3; ++i) xyz[i] /= kWhite[i];
  return xyz;
}

/// The opponent colours in which the eye's sensitivity to contrast is known.
Color opponent_from_rgb(const Color& rgb) {
  const Color xyz = relative_xyz(rgb);
  return {116 * xyz[1] - 16, 500 * (xyz[0] - xyz[1]), 200 * (xyz[1] - xyz[2])};
}

Color rgb_from_opponent(const Color& c) {
  const float y = (c[0] + 16) / 116;
  Color rgb = times(kRgbFromXyz, {(y + c[1] / 500) * kWhite[0], y * kWhite[1], (y - c[2] / 200) * kWhite[2]});
  for (float& v : rgb) v = std::clamp(v, 0.0f, 1.0f);
  return rgb;
}

/// CIELAB, with less colour where it is dark (Hunt's effect).
Color hunt_lab(const Color& rgb) {
  Color f = relative_xyz(rgb);
  constexpr float kDelta = 6.0f / 29;
  for (float& v : f) v = v > kDelta * kDelta * kDelta ? std::cbrt(v) : v / (3 * kDelta * kDelta) + 4.0f / 29;
  const float lightness = 116 * f[1] - 16;
  return {lightness, 0.01f * lightness * 500 * (f[0] - f[1]), 0.01f * lightness * 200 * (f[1] - f[2])};
}

float hyab(const Color& a, const Color& b) {
  return std::abs(a[0] - b[0]) + std::hypot(a[1] - b[1], a[2] - b[2]);
}

/// Colours as an eye at a distance sees them: each opponent channel through its contrast sensitivity, a sum
/// of two Gaussians a sqrt(pi / b) exp(-pi^2 d^2 / b) of the distance d in degrees.
Planes blurred(const Planes& opponent, const Convolver& convolve) {
  struct Lobe {
    double a, b;
  };
  constexpr Lobe kLobes[3][2] = {
      {{1, 0.0047}, {0, 1e-5}}, {{1, 0.0053}, {0, 1e-5}}, {{34.1, 0.04}, {13.5, 0.025}}};
  const int radius = static_cast<int>(std::ceil(3 * std::sqrt(0.04 / (2 * kPi * kPi)) * kPixelsPerDegree));
  Planes out;
  for (std::size_t c = 0; c < 3; ++c) {
    out[c].assign(opponent[c].size(), 0.0f);
    double total = 0;
    for (const Lobe& lobe : kLobes[c]) {
      if (lobe.a == 0) continue;
      const Taps taps = gaussian(radius, -kPi * kPi / (lobe.b * kPixelsPerDegree * kPixelsPerDegree));
      const double weight = lobe.a * std::sqrt(kPi / lobe.b);
      total += weight * sum_of(taps) * sum_of(taps);
      const Plane part = convolve(opponent[c], taps, taps);
      for (std::size_t i = 0; i < part.size(); ++i) out[c][i] += static_cast<float>(weight) * part[i];
    }
    for (float& v : out[c]) v /= static_cast<float>(total);
  }
  return out;
}

/// Strength of edges and of points in the luminance.
std::array<Plane, 2> features(const Plane& luminance, const Convolver& convolve) {
  constexpr double kSigma = 0.5 * 0.082 * kPixelsPerDegree;
  const int radius = static_cast<int>(std::ceil(3 * kSigma));
  Taps smooth = gaussian(radius, -1 / (2 * kSigma * kSigma)), edge = smooth, point = smooth;
  for (int i = -radius; i <= radius; ++i) {
    const auto at = static_cast<std::size_t>(i + radius);
    edge[at] *= static_cast<float>(-i);
    point[at] *= static_cast<float>(i * i / (kSigma * kSigma) - 1);
  }
  balance(smooth), balance(edge), balance(point);
  std::array<Plane, 2> out;
  for (std::size_t k = 0; k < 2; ++k) {
    const Taps& detector = k == 0 ? edge : point;
    const Plane across = convolve(luminance, detector, smooth), down = convolve(luminance, smooth, detector);
    for (std::size_t i = 0; i < across.size(); ++i) out[k].push_back(std::hypot(across[i], down[i]));
  }
  return out;
}

struct Seen {
  Planes color;                  // blurred, opponent
  std::array<Plane, 2> feature;  // edges, points

  Seen(const Image& image, const Convolver& convolve) {
    const RgbPlanes rgb = rgb_planes(image);
    Planes opponent;
    Plane luminance;
    for (std::size_t i = 0; i < image.pixel_count(); ++i) {
      Color shown{rgb.r[i], rgb.g[i], rgb.b[i]};
      for (float& v : shown) v = v > 0 ? std::min(v, 1.0f) : 0.0f;  // NaN is black
      const Color c = opponent_from_rgb(shown);
      for (std::size_t k = 0; k < 3; ++k) opponent[k].push_back(c[k]);
      luminance.push_back((c[0] + 16) / 116);
    }
    color = blurred(opponent, convolve);
    feature = features(luminance, convolve);
  }
  Color lab(std::size_t i) const {
    return hunt_lab(rgb_from_opponent({color[0][i], color[1][i], color[2][i]}));
  }
};

/// Colour differences up to 0.4 of the largest take 0.95 of the scale.
float redistributed(float difference, float largest) {
  constexpr float kKnee = 0.4f, kValue = 0.95f;
  const float knee = kKnee * largest;
  if (difference < knee) return kValue / knee * difference;
  return kValue + (difference - knee) / (largest - knee) * (1 - kValue);
}

}  // namespace

absl::StatusOr<double> flip_error(const Image& reference, const Image& test) {
  const int width = reference.data.width(), height = reference.data.height();
  if (reference.pixel_count() == 0 || width != test.data.width() || height != test.data.height()) {
    return absl::InvalidArgumentError(absl::StrCat("image sizes differ or are empty: ", width, "x", height,
                                                   " and ", test.data.width(), "x", test.data.height()));
  }
  const Convolver convolve(width, height);
  const Seen a(reference, convolve), b(test, convolve);
  const float largest = std::pow(hyab(hunt_lab({0, 1, 0}), hunt_lab({0, 0, 1})), 0.7f);
  double sum = 0;
  for (std::size_t i = 0; i < reference.pixel_count(); ++i) {
    const float color = redistributed(std::pow(hyab(a.lab(i), b.lab(i)), 0.7f), largest);
    const float feature = std::max(std::abs(a.feature[0][i] - b.feature[0][i]),  //
                                   std::abs(a.feature[1][i] - b.feature[1][i]));
    sum += std::pow(color, 1 - std::sqrt(feature / std::numbers::sqrt2_v<float>));
  }
  return sum / static_cast<double>(reference.pixel_count());
}

}  // namespace tessera::client
