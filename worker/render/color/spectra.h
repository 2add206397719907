// How colours and curves of tables look to the light that a path carries.
//
// Kernels for RGB take colours as they are: all of this is then nothing. Kernels for wavelengths look each up
// at the path's four wavelengths: reflectances as the sigmoids of quadratic polynomials that have their
// colours [Jakob & Hanika 2019], measured spectra as they were measured.
#pragma once

#include "render/color/spectral_tables.h"
#include "render/color/spectrum.h"

namespace tessera::render::TESSERA_ISA {

#ifdef TESSERA_SPECTRAL

/// One wavelength a lane of the path's Spectrum, in nanometres, from kFirstNm to kLastNm.
struct Wavelengths {
  Float c[kSpectrumLanes];
};

/// In nanometres; kernels for RGB return the number that they are given.
TESSERA_INLINE Float first_wavelength(const Wavelengths& wavelengths, Float) { return wavelengths.c[0]; }

/// Wavelengths for a path, in proportion to what the sensor sees: that of u(), which is uniform in [0, 1),
/// and others at even distances in quantiles [Wilkie et al. 2014].
template <class Number>
TESSERA_INLINE Wavelengths sample_wavelengths(const SensitivityTable& sensor, Number&& u) {
  Wavelengths result;
  const auto count = static_cast<std::int32_t>(sensor.quantiles.size());
  const float* const first = &sensor.quantiles.data()->nm;
  const Float number = u();
  for (int i = 0; i < kSpectrumLanes; ++i) {
    Float place = number + static_cast<float>(i) / kSpectrumLanes;
    place = select(place >= 1.0f, place - 1.0f, place) * static_cast<float>(count);
    const Int quantile = min(to_int(place), count - 1);
    const Float nm = gather(first, quantile * 2, Mask::all()),
                width = gather(first + 1, quantile * 2, Mask::all());
    result.c[i] = fma(place - to_float(quantile), width, nm);
  }
  return result;
}

/// The part that light of one in a lane of a path's Spectrum adds to a picture.
struct LaneResponse {
  Color color[kSpectrumLanes];   // red, green and blue
  Float weight[kSpectrumLanes];  // radiance, over all wavelengths that are sampled
};
/// Looks SensitivityTable::light or matter up.
LaneResponse lane_response(const SensitivityTable& sensor, const std::vector<float>& response,
                           const Wavelengths& wavelengths);

/// The scene's colours and curves at the wavelengths of 16 paths.
class Spectra {
 public:
  /// The tables must outlive it.
  TESSERA_INLINE Spectra(const SpectralTables* tables, const Wavelengths& wavelengths)
      : tables_(tables), wavelengths_(wavelengths) {}

  const Wavelengths& wavelengths() const { return wavelengths_; }

  /// A constant of a table: the coefficients of a sigmoid where `curve` is negative, else the value of the
  /// curve.
  Spectrum constant(const Color& coefficients, Int curve, Mask active) const;
  /// The curves of these numbers.
  Spectrum curve(Int number, Mask active) const;
  /// A factor of light that has this colour in daylight, of any size; up to 1 where the colour is.
  Spectrum factor(const Color& color, Mask active) const;
  /// A density of this colour: at no wavelength above twice its largest component. Of greys, it is that.
  Spectrum density(const Color& color, Mask active) const;
  /// Light of this colour: the curve of its lamp, daylight where `curve` is negative, times the factor.
  Spectrum light(const Color& color, Int curve, Mask active) const;

 private:
  /// `scale` times the reflectance of the colour over it, but of greys the colour.
  Spectrum scaled(const Color& positive, Float scale, Mask active) const;

  const SpectralTables* tables_;
  Wavelengths wavelengths_;
};

#else

struct Wavelengths {};

TESSERA_INLINE Float first_wavelength(const Wavelengths&, Float otherwise) { return otherwise; }

template <class Number>
TESSERA_INLINE Wavelengths sample_wavelengths(const SensitivityTable&, Number&&) {
  return {};
}

class Spectra {
 public:
  Spectra() = default;
  TESSERA_INLINE Spectra(const SpectralTables*, const Wavelengths&) {}

  TESSERA_INLINE Wavelengths wavelengths() const { return {}; }
  TESSERA_INLINE Spectrum constant(const Color& color, Int, Mask) const { return color; }
  TESSERA_INLINE Spectrum factor(const Color& color, Mask) const { return color; }
  TESSERA_INLINE Spectrum density(const Color& color, Mask) const { return color; }
  TESSERA_INLINE Spectrum light(const Color& color, Int, Mask) const { return color; }
};

#endif

}  // namespace tessera::render::TESSERA_ISA
