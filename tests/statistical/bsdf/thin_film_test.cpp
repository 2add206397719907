// Thin films in RGB against the interference of every wavelength.
#include <gtest/gtest.h>

#include <complex>
#include <cstdio>

#include "render/bsdf/model/gltf/thin_film.h"
#include "spectra/light/daylight.h"
#include "spectra/observer/observer.h"
#include "support/kernel/bsdf_cases.h"

namespace tessera::test {
namespace {

using Complex = std::complex<double>;
using Rgb = std::array<double, 3>;

/// Airy's reflectance of a film between air and a base, in the mean of both polarisations [Born &
/// Wolf, 1.6.4], by the amplitudes of the boundaries and the phase that the film adds.
double airy(double cosine, double film, double base, double thickness_nm, double wavelength_nm) {
  const auto within = [&](double index) { return std::sqrt(1 - (1 - cosine * cosine) / (index * index)); };
  const double c2 = within(film), c3 = within(base);
  const double phase = 4 * M_PI * film * thickness_nm * c2 / wavelength_nm;
  const auto reflectance = [&](double r12, double r23) {
    const Complex back = std::polar(r23, phase);
    return std::norm((r12 + back) / (1.0 + r12 * back));
  };
  const double s = reflectance((cosine - film * c2) / (cosine + film * c2),
                               (film * c2 - base * c3) / (film * c2 + base * c3));
  const double p = reflectance((film * cosine - c2) / (film * cosine + c2),
                               (base * c2 - film * c3) / (base * c2 + film * c3));
  return (s + p) / 2;
}

/// Rec.709 of a reflectance under D65, relative to white; every half nanometre.
template <class F>
Rgb seen(F&& reflectance) {
  static const spectra::Curve d65 = spectra::illuminant_d65();
  Rgb sum{}, white{};
  for (double nm = 360.25; nm < 830; nm += 0.5) {
    const double light = d65.at(nm);
    const auto [x, y, z] = spectra::cie1931().at(nm);
    const Rgb rgb{3.2404542 * x - 1.5371385 * y - 0.4985314 * z,
                  -0.9692660 * x + 1.8760108 * y + 0.0415560 * z,
                  0.0556434 * x - 0.2040259 * y + 1.0572252 * z};
    const double value = reflectance(nm);
    for (std::size_t c = 0; c < 3; ++c) sum[c] += rgb[c] * light * value, white[c] += rgb[c] * light;
  }
  for (std::size_t c = 0; c < 3; ++c) sum[c] = std::clamp(sum[c] / white[c], 0.0, 1.0);
  return sum;
}

TEST(ThinFilm, IsTheMeanOverWavelengths) {
  const std::vector<float> table = render::film_table();
  double worst = 0, squares = 0;
  int count = 0;
  for (const double eta : {1.2, 1.33, 1.5, 1.8, 2.4}) {
    for (const double f0 : {0.0, 0.02, 0.04, 0.17, 0.5, 0.9, 0.98}) {
      const double root = std::sqrt(f0), base = (1 + root) / (1 - root);
      for (const double nm : {0.0, 50.0, 120.0, 250.0, 400.0, 640.0, 1000.0, 2500.0}) {
        for (const double cosine : {1.0, 0.8, 0.5, 0.2, 0.05}) {
          SCOPED_TRACE(number(static_cast<float>(eta)) + " over " + number(static_cast<float>(f0)) + ", " +
                       number(static_cast<float>(nm)) + " nm, cosine " + number(static_cast<float>(cosine)));
          const kernel::ThinFilm film{table.data(), static_cast<float>(eta), static_cast<float>(nm)};
          const kernel::Spectrum rgb = film.reflectance(
              static_cast<float>(cosine), kernel::Spectrum(static_cast<float>(f0)), kernel::Mask::all());
          const Rgb expected =
              seen([&](double wavelength) { return airy(cosine, eta, base, nm, wavelength); });
          for (int c = 0; c < 3; ++c) {
            const double error = std::abs(double{rgb.c[c].lane(0)} - expected[static_cast<std::size_t>(c)]);
            EXPECT_LT(error, 0.01);
            worst = std::max(worst, error), squares += error * error, ++count;
          }
        }
      }
    }
  }
  std::printf("films: worst error %.4f, root mean square %.5f\n", worst, std::sqrt(squares / count));
}

}  // namespace
}  // namespace tessera::test
