#include "render/textbook/irradiance_cache/harmonics.h"

#include <cmath>
#include <numbers>

namespace tessera::render::TESSERA_ISA {

Harmonics::Harmonics(int bands) : bands_(bands), first_{}, up_{}, down_{} {
  for (int m = 0; m < bands; ++m) {
    // sqrt(2) on the half sphere, and again for the pairs of m > 0.
    first_[m] = static_cast<float>(m == 0   ? std::sqrt(0.5 * std::numbers::inv_pi)
                                   : m == 1 ? std::sqrt(3.0)
                                            : std::sqrt((2 * m + 1) / (2.0 * m)));
    for (int l = m + 1; l < bands; ++l) {
      const double square = l * l - m * m, before = (l - 1) * (l - 1) - m * m;
      const double up = std::sqrt((4.0 * l * l - 1) / square);
      up_[m][l] = static_cast<float>(up);
      down_[m][l] = static_cast<float>(up * std::sqrt(before / (4.0 * (l - 1) * (l - 1) - 1)));
    }
  }
}

void Harmonics::evaluate(Vec3 d, Float* values) const {
  Float cosine(1.0f), sine(0.0f);  // cos and sin of m times the azimuth, times the polar sine to the m-th
  Float start(1.0f);               // l = m
  for (int m = 0; m < bands_; ++m) {
    start = start * first_[m];
    Float before(0.0f), here = start;
    for (int l = m; l < bands_; ++l) {
      if (l > m) {
        const Float next = fma(d.z * here, Float(up_[m][l]), before * -down_[m][l]);
        before = here, here = next;
      }
      if (((l - m) & 1) != 0) continue;
      *values++ = here * cosine;
      if (m > 0) *values++ = here * sine;
    }
    const Float turned = cosine * d.x - sine * d.y;
    sine = fma(sine, d.x, cosine * d.y);
    cosine = turned;
  }
}

}  // namespace tessera::render::TESSERA_ISA
