// pbrt spectrum parameters -> Spectrum messages.
#pragma once

#include <optional>

#include "import/pbrt/context.h"
#include "import/pbrt/file/parameters.h"

namespace tessera::client::pbrt {

enum class SpectrumUse { kReflectance, kUnbounded, kIlluminant };

/// The parameter types that can stand for a spectrum.
inline constexpr std::initializer_list<ParameterType> kSpectrumTypes = {
    ParameterType::kRgb, ParameterType::kSpectrum, ParameterType::kBlackbody, ParameterType::kFloat};

v1::Spectrum constant_spectrum(double value);
v1::Spectrum rgb_spectrum(const std::array<double, 3>& rgb);

/// Factors apply to values of any kind; a scaled blackbody comes out as samples.
v1::Spectrum scaled(const v1::Spectrum& spectrum, double factor);
v1::Spectrum sum(const v1::Spectrum& a, const v1::Spectrum& b);
/// Whether the spectrum was measured, or is that of a black body: more than a colour.
bool is_table(const v1::Spectrum& spectrum);
/// a / b, and 0 where b is 0: sampled at whole nanometres, where renderers look.
v1::Spectrum sampled_ratio(const v1::Spectrum& a, const v1::Spectrum& b);
/// Linear Rec.709 of a spectrum of matter, for places that hold nothing else; no component is below 0.
std::array<double, 3> linear_rgb_of(const v1::Spectrum& spectrum);

/// The value of a parameter of one of kSpectrumTypes; nothing after an error. RGB comes out in linear
/// Rec.709. Sampled reflectances and illuminants are zero outside the wavelengths given, as in pbrt; indices
/// of refraction are constant there.
std::optional<v1::Spectrum> read_spectrum(Context& context, const Parameter& parameter,
                                          std::string_view owner, SpectrumUse use);

/// A spectrum of a light, and the factor that brings it to what pbrt-v4 renders.
struct LightSpectrum {
  v1::Spectrum spectrum;
  double scale = 1;
};

/// Parameter `name` of a light; white where it is absent.
///
/// pbrt-v4 divides every light spectrum by its integral against the CIE function y (for RGB: that of the
/// colour space's illuminant) and integrates the image against the same y without normalising. So in the
/// image `rgb L` arrives as exactly that RGB, and any other spectrum as its own chromaticity with luminance
/// 1, whatever its magnitude. Here spectra keep their values and `scale` is 1 over their luminance.
LightSpectrum read_light_spectrum(Context& context, ParameterList& parameters, std::string_view name);

}  // namespace tessera::client::pbrt
