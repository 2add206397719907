#include "spectra/light/illuminants.h"

#include <array>
#include <cmath>
#include <cstddef>

#include "spectra/light/daylight.h"
#include "spectra/light/lamps.h"

namespace tessera::spectra {
namespace {

// 300 to 780 nm in steps of 5 nm.
constexpr float kIlluminantC[] = {
    0,       0,      0,       0,      0.01f,   0.2f,    0.4f,   1.55f,   2.7f,    4.85f,   7,
    9.95f,   12.9f,  17.2f,   21.4f,  27.5f,   33,      39.92f, 47.4f,   55.17f,  63.3f,   71.81f,
    80.6f,   89.53f, 98.1f,   105.8f, 112.4f,  117.75f, 121.5f, 123.45f, 124,     123.6f,  123.1f,
    123.3f,  123.8f, 124.09f, 123.9f, 122.92f, 120.7f,  116.9f, 112.1f,  106.98f, 102.3f,  98.81f,
    96.9f,   96.78f, 98,      99.94f, 102.1f,  103.95f, 105.2f, 105.67f, 105.3f,  104.11f, 102.3f,
    100.15f, 97.8f,  95.43f,  93.2f,  91.22f,  89.7f,   88.83f, 88.4f,   88.19f,  88.1f,   88.06f,
    88,      87.86f, 87.8f,   87.99f, 88.2f,   88.2f,   87.9f,  87.22f,  86.3f,   85.3f,   84,
    82.21f,  80.2f,  78.24f,  76.3f,  74.36f,  72.4f,   70.4f,  68.3f,   66.3f,   64.4f,   62.8f,
    61.5f,   60.2f,  59.2f,   58.5f,  58.1f,   58,      58.2f,  58.5f,   59.1f};

// Incandescent light: by definition Planck's law at 2848 K with the radiation constant of its time.
Curve illuminant_a() {
  std::array<float, 107> values;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double nm = 300 + 5.0 * static_cast<double>(i);
    const double c2 = 1.435e7;
    values[i] = static_cast<float>(100 * std::pow(560 / nm, 5) * std::expm1(c2 / (2848 * 560)) /
                                   std::expm1(c2 / (2848 * nm)));
  }
  return uniform_curve(300, 5, values);
}

/// The radiation constant c2 was 1.4380e-2 m K when the nominal temperatures of daylights were chosen.
constexpr double kNominalKelvin = 1.4388 / 1.4380;

}  // namespace

std::optional<Curve> find_illuminant(std::string_view name) {
  if (name == "A") return illuminant_a();
  if (name == "C") return uniform_curve(300, 5, kIlluminantC);
  if (name == "D50") return daylight(5000 * kNominalKelvin);
  if (name == "D55") return daylight(5500 * kNominalKelvin);
  if (name == "D65") return illuminant_d65();
  if (name == "D75") return daylight(7500 * kNominalKelvin);
  if (name == "E") return Curve{{300, 830}, {100, 100}};
  if (name == "acesD60") return illuminant_aces_d60();
  if (std::optional<Curve> lamp = find_fluorescent(name)) return lamp;
  return find_led(name);
}

}  // namespace tessera::spectra
