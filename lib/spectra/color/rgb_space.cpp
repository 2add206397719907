#include "spectra/color/rgb_space.h"

#include <cstddef>

namespace tessera::spectra {
namespace {

constexpr Matrix3 kBradford = {
    {{0.8951, 0.2664, -0.1614}, {-0.7502, 1.7135, 0.0367}, {0.0389, -0.0685, 1.0296}}};

Matrix3 diagonal(const Triple& values) { return {{{values[0], 0, 0}, {0, values[1], 0}, {0, 0, values[2]}}}; }

bool operator==(const Chromaticity& a, const Chromaticity& b) { return a.x == b.x && a.y == b.y; }

}  // namespace

Triple times(const Matrix3& matrix, const Triple& vector) {
  Triple result;
  for (std::size_t r = 0; r < 3; ++r)
    result[r] = matrix[r][0] * vector[0] + matrix[r][1] * vector[1] + matrix[r][2] * vector[2];
  return result;
}

Matrix3 product(const Matrix3& left, const Matrix3& right) {
  Matrix3 result{};
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::size_t i = 0; i < 3; ++i) result[r][c] += left[r][i] * right[i][c];
    }
  }
  return result;
}

Matrix3 inverse(const Matrix3& m) {
  const auto cofactor = [&](std::size_t r, std::size_t c) {
    const std::size_t r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
    return m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1];
  };
  const double determinant = m[0][0] * cofactor(0, 0) + m[0][1] * cofactor(0, 1) + m[0][2] * cofactor(0, 2);
  Matrix3 result;
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t c = 0; c < 3; ++c) result[r][c] = cofactor(c, r) / determinant;
  }
  return result;
}

Matrix3 xyz_from_rgb(const RgbSpace& space) {
  const Triple red = xyz_of(space.red), green = xyz_of(space.green), blue = xyz_of(space.blue);
  const Matrix3 primaries = {
      {{red[0], green[0], blue[0]}, {red[1], green[1], blue[1]}, {red[2], green[2], blue[2]}}};
  return product(primaries, diagonal(times(inverse(primaries), xyz_of(space.white))));
}

Matrix3 rgb_from_xyz(const RgbSpace& space) { return inverse(xyz_from_rgb(space)); }

Matrix3 bradford(const Chromaticity& from, const Chromaticity& to) {
  if (from == to) return diagonal({1, 1, 1});
  const Triple cones_from = times(kBradford, xyz_of(from)), cones_to = times(kBradford, xyz_of(to));
  const Triple gains = {cones_to[0] / cones_from[0], cones_to[1] / cones_from[1],
                        cones_to[2] / cones_from[2]};
  return product(inverse(kBradford), product(diagonal(gains), kBradford));
}

Matrix3 rgb_from_xyz(const RgbSpace& space, const Chromaticity& white) {
  return product(rgb_from_xyz(space), bradford(white, space.white));
}

Matrix3 rgb_from_rgb(const RgbSpace& to, const RgbSpace& from) {
  return product(rgb_from_xyz(to, from.white), xyz_from_rgb(from));
}

}  // namespace tessera::spectra
