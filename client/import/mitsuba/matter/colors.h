// Colours as Mitsuba 3's RGB modes see them.
#pragma once

#include <array>
#include <optional>

#include "import/mitsuba/document/property_reader.h"
#include "spectra/curve.h"

namespace tessera::client::mitsuba {

/// Mitsuba's range of wavelengths, which curves that are the same everywhere span.
inline constexpr float kFirstNm = 360, kLastNm = 830;

enum class ColorUse {
  kReflectance,  // values within 0..1
  kUnbounded,    // indices of refraction, extinction
  kEmission,
  kSensitivity,  // of a sensor: the curve counts, and its colour is nobody's
};

/// A value that is the same everywhere: in Mitsuba's RGB modes linear Rec.709, and in its spectral ones a
/// curve, or, where that is empty, a spectrum that the colour has there.
struct ConstantColor {
  std::array<double, 3> rgb = {};
  spectra::Curve curve = {};

  v1::Spectrum to_spectrum() const;
  ConstantColor& operator*=(double factor);
};

v1::Spectrum rgb_spectrum(const std::array<double, 3>& rgb);
v1::Spectrum constant_spectrum(double value);

/// The value of a number, <rgb>, <spectrum> or constant texture ("uniform", "srgb", "d65", "rawconstant",
/// "regular", "irregular", "blackbody"); nothing for textures that vary, and for other types.
///
/// Numbers and <rgb> stand for themselves. Sampled spectra are integrated (spectra/rgb/mitsuba_rgb.h):
/// emitted ones as they are, others under D65. A uniform emitted <spectrum> is an equal-energy one, whose
/// colour is not grey.
std::optional<ConstantColor> read_constant_color(PropertyReader& reader, const Property& property,
                                                 ColorUse use);

/// The constant colour of parameter `name`, `fallback` where it is absent; an error where it is something
/// else.
ConstantColor read_color(PropertyReader& reader, std::string_view name, double fallback, ColorUse use);

}  // namespace tessera::client::mitsuba
