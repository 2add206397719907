#include "spectra/light/daylight.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

#include "spectra/color/tristimulus.h"

namespace tessera::spectra {
namespace {

constexpr std::array<float, kDaylightCount> kPbrtD50 = {
    0.0192f,  2.054f,   7.772f,   14.7395f, 17.9386f, 20.9949f, 23.9251f, 26.9427f, 24.461f,
    29.8404f, 49.664f,  56.648f,  60.244f,  58.216f,  75.732f,  88.264f,  91.596f,  92.284f,
    96.028f,  92.596f,  96.252f,  97.072f,  97.556f,  102.456f, 100.932f, 102.424f, 100,
    96.0734f, 95.2835f, 89.8707f, 91.6744f, 91.8047f, 90.1249f, 85.8717f, 87.5589f, 84.5791f,
    85.7562f, 88.4966f, 85.0434f, 74.9461f, 77.8232f, 79.5195f, 65.869f,  74.4892f, 79.936f,
    67.6589f, 49.6084f, 71.3158f, 67.4956f, 68.569f,  63.3488f, 55.3185f, 61.1387f, 64.2855f};
constexpr std::array<float, kDaylightCount> kAcesD60 = {
    0.02928f,  2.55f,     15.5176f,  28.3765f,  31.4902f,  36.0251f,  38.3813f,  42.9077f,  41.207f,
    46.4172f,  72.1085f,  80.2427f,  82.7329f,  77.5372f,  95.5782f,  107.8627f, 109.4796f, 107.695f,
    109.6246f, 103.6606f, 105.1953f, 104.3995f, 102.5132f, 106.0494f, 103.3083f, 103.5373f, 100,
    96.7538f,  96.7165f,  89.8861f,  91.948f,   92.0313f,  90.5703f,  86.4451f,  87.4651f,  83.8465f,
    84.5686f,  87.3178f,  83.2958f,  74.0243f,  76.4464f,  78.9029f,  65.3486f,  73.9732f,  79.3872f,
    67.1899f,  49.182f,   70.7626f,  67.0452f,  68.0486f,  62.8776f,  54.8943f,  60.7189f,  63.7793f};

// Mean daylight and its first two components [CIE 15:2004]. The 5 nm tables are linear in between.
constexpr std::array<double, kDaylightCount> kS0 = {
    0.04,   6.00,   29.60,  55.30,  57.30,  61.80,  61.50,  68.80,  63.40,  65.80,  94.80,
    104.80, 105.90, 96.80,  113.90, 125.60, 125.50, 121.30, 121.30, 113.50, 113.10, 110.80,
    106.50, 108.80, 105.30, 104.40, 100.00, 96.00,  95.10,  89.10,  90.50,  90.30,  88.40,
    84.00,  85.10,  81.90,  82.60,  84.90,  81.30,  71.90,  74.30,  76.40,  63.30,  71.70,
    77.00,  65.20,  47.70,  68.60,  65.00,  66.00,  61.00,  53.30,  58.90,  61.90};
constexpr std::array<double, kDaylightCount> kS1 = {
    0.02,   4.50,   22.40,  42.00,  40.60,  41.60,  38.00,  42.40,  38.50,  35.00,  43.40,
    46.30,  43.90,  37.10,  36.70,  35.90,  32.60,  27.90,  24.30,  20.10,  16.20,  13.20,
    8.60,   6.10,   4.20,   1.90,   0,      -1.60,  -3.50,  -3.50,  -5.80,  -7.20,  -8.60,
    -9.50,  -10.90, -10.70, -12.00, -14.00, -13.60, -12.00, -13.30, -12.90, -10.60, -11.60,
    -12.20, -10.20, -7.80,  -11.20, -10.40, -10.60, -9.70,  -8.30,  -9.30,  -9.80};
constexpr std::array<double, kDaylightCount> kS2 = {
    0,     2.00,  4.00,  8.50,  7.80,  6.70,  5.30,  6.10,  3.00,  1.20,  -1.10, -0.50, -0.70, -1.20,
    -2.60, -2.90, -2.80, -2.60, -2.60, -1.80, -1.50, -1.30, -1.20, -1.00, -0.50, -0.30, 0,     0.20,
    0.50,  2.10,  3.20,  4.10,  4.70,  5.10,  6.70,  7.30,  8.60,  9.80,  10.20, 8.30,  9.60,  8.50,
    7.00,  7.60,  8.00,  6.70,  5.20,  7.40,  6.80,  7.00,  6.40,  5.50,  6.10,  6.50};

Curve daylight_curve(std::span<const float> values) {
  return uniform_curve(static_cast<float>(kDaylightFirstNm), static_cast<float>(kDaylightStepNm), values);
}

}  // namespace

Curve pbrt_d50() { return daylight_curve(kPbrtD50); }

Curve illuminant_d65() {
  std::array<float, kDaylightCount> values{};
  std::copy(kD65Power.begin(), kD65Power.end(), values.begin());
  return daylight_curve(values);
}

Curve unit_d65() {
  Curve curve = illuminant_d65();
  const double luminance = tristimulus(curve, cie1931())[1];
  for (float& value : curve.values) value = static_cast<float>(value / luminance);
  return curve;
}

Curve illuminant_aces_d60() { return daylight_curve(kAcesD60); }

std::optional<Curve> daylight(double kelvin) {
  if (!(kelvin >= 4000 && kelvin <= 25000)) return std::nullopt;
  const double k = 1e3 / kelvin;
  const double x = kelvin <= 7000 ? ((-4.6070 * k + 2.9678) * k + 0.09911) * k + 0.244063
                                  : ((-2.0064 * k + 1.9018) * k + 0.24748) * k + 0.237040;
  const double y = (-3.000 * x + 2.870) * x - 0.275;
  const double m = 0.0241 + 0.2562 * x - 0.7341 * y;
  const auto in_thousandths = [](double value) { return std::round(value * 1000) / 1000; };
  const double m1 = in_thousandths((-1.3515 - 1.7703 * x + 5.9114 * y) / m);
  const double m2 = in_thousandths((0.0300 - 31.4424 * x + 30.0717 * y) / m);
  std::array<float, kDaylightCount> values{};
  for (std::size_t i = 0; i < kDaylightCount; ++i)
    values[i] = static_cast<float>(kS0[i] + m1 * kS1[i] + m2 * kS2[i]);
  return daylight_curve(values);
}

}  // namespace tessera::spectra
