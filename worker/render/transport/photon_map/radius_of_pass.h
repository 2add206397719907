// Radii that shrink from pass to pass.
#pragma once

#include <cmath>
#include <cstdint>

namespace tessera::render::TESSERA_ISA {

/// The radius of pass `pass`, 0 the first, `first` being the first's: r_i = r_1 i^((alpha - 1) / 2), so that
/// no pass needs to know of others [Knaus & Zwicker 2011, equation 20, whose product has this asymptote]. The
/// variance of pass i grows as i^(1 - alpha), and its bias falls as i^(alpha - 1): with 2/3 the variance and
/// the squared bias of the mean of N passes fall together, as N^(-2/3) [section 4].
inline float radius_of_pass(float first, std::uint32_t pass) {
  constexpr double kAlpha = 2.0 / 3;
  return static_cast<float>(double{first} * std::pow(1.0 + pass, (kAlpha - 1) / 2));
}

}  // namespace tessera::render::TESSERA_ISA
