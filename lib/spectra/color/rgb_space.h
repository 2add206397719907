// RGB spaces by their primaries, and the ways between them.
#pragma once

#include <array>

#include "spectra/color/tristimulus.h"

namespace tessera::spectra {

/// Row-major; `m * v` is times(m, v).
using Matrix3 = std::array<Triple, 3>;

Triple times(const Matrix3& matrix, const Triple& vector);
Matrix3 product(const Matrix3& left, const Matrix3& right);
/// Requires a determinant that is not 0.
Matrix3 inverse(const Matrix3& matrix);

/// Chromaticities of the CIE 1931 observer.
struct RgbSpace {
  Chromaticity red, green, blue, white;
};

inline constexpr Chromaticity kWhiteD65 = {0.3127, 0.3290};

/// [ITU-R BT.709; IEC 61966-2-1]
inline constexpr RgbSpace kRec709 = {{0.64, 0.33}, {0.30, 0.60}, {0.15, 0.06}, kWhiteD65};
/// [ITU-R BT.2020]
inline constexpr RgbSpace kRec2020 = {{0.708, 0.292}, {0.170, 0.797}, {0.131, 0.046}, kWhiteD65};
/// DCI-P3's primaries with the white of displays [SMPTE RP 431-2].
inline constexpr RgbSpace kP3D65 = {{0.680, 0.320}, {0.265, 0.690}, {0.150, 0.060}, kWhiteD65};
/// AP1 [Academy S-2014-004].
inline constexpr RgbSpace kAcesCg = {{0.713, 0.293}, {0.165, 0.830}, {0.128, 0.044}, {0.32168, 0.33767}};
/// AP0, of ACES2065-1 [SMPTE ST 2065-1].
inline constexpr RgbSpace kAces2065 = {{0.7347, 0.2653}, {0, 1}, {0.0001, -0.0770}, {0.32168, 0.33767}};

/// Linear RGB to XYZ: (1, 1, 1) becomes the space's white with Y = 1.
Matrix3 xyz_from_rgb(const RgbSpace& space);
Matrix3 rgb_from_xyz(const RgbSpace& space);

/// XYZ seen with the eye adapted to `from` as XYZ of the same look to an eye adapted to `to` [Lam 1985].
Matrix3 bradford(const Chromaticity& from, const Chromaticity& to);

/// XYZ of a scene whose white is `white` to linear RGB, white on white.
Matrix3 rgb_from_xyz(const RgbSpace& space, const Chromaticity& white);

/// Linear RGB of one space to that of another, white on white.
Matrix3 rgb_from_rgb(const RgbSpace& to, const RgbSpace& from);

}  // namespace tessera::spectra
