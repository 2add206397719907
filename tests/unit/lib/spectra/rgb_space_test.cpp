#include "spectra/color/rgb_space.h"

#include <gtest/gtest.h>

namespace tessera::spectra {
namespace {

void expect_matrix(const Matrix3& found, const Matrix3& expected, double tolerance) {
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(found[r][c], expected[r][c], tolerance) << r << " " << c;
  }
}

TEST(RgbSpace, Rec709IsThatOfTheStandard) {
  // [IEC 61966-2-1] with seven digits, which is computed from another white: 0.95047 1 1.08883.
  expect_matrix(rgb_from_xyz(kRec709),
                {{{3.2404542, -1.5371385, -0.4985314},
                  {-0.9692660, 1.8760108, 0.0415560},
                  {0.0556434, -0.2040259, 1.0572252}}},
                1.5e-3);
}

TEST(RgbSpace, WhiteIsWhite) {
  for (const RgbSpace* space : {&kRec709, &kRec2020, &kP3D65, &kAcesCg}) {
    const Triple white = times(xyz_from_rgb(*space), {1, 1, 1}), expected = xyz_of(space->white);
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(white[c], expected[c], 1e-12);
    const Chromaticity red = chromaticity(times(xyz_from_rgb(*space), {1, 0, 0}));
    EXPECT_NEAR(red.x, space->red.x, 1e-12);
    EXPECT_NEAR(red.y, space->red.y, 1e-12);
    for (const RgbSpace* other : {&kRec709, &kAcesCg}) {
      const Triple there = times(rgb_from_rgb(*other, *space), {1, 1, 1});
      for (const double component : there) EXPECT_NEAR(component, 1, 1e-12);
    }
    expect_matrix(product(rgb_from_xyz(*space), xyz_from_rgb(*space)), {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}},
                  1e-12);
  }
}

TEST(RgbSpace, WideGamutsToRec709) {
  // The matrices of the pbrt importer (color_space.cpp), with ten digits.
  expect_matrix(rgb_from_rgb(kRec709, kP3D65),
                {{{1.2249401763, -0.2249401763, 0},
                  {-0.0420569547, 1.0420569547, 0},
                  {-0.0196375546, -0.0786360456, 1.0982736001}}},
                1e-9);
  expect_matrix(rgb_from_rgb(kRec709, kRec2020),
                {{{1.6604910021, -0.5876411388, -0.0728498633},
                  {-0.1245504745, 1.1328998971, -0.0083494226},
                  {-0.0181507634, -0.1005788980, 1.1187296614}}},
                1e-9);
  // AP0 by the same way: the whites differ, which is Bradford's part.
  constexpr RgbSpace kAces2065 = {{0.73470, 0.26530}, {0, 1}, {0.00010, -0.07700}, {0.32168, 0.33767}};
  expect_matrix(rgb_from_rgb(kRec709, kAces2065),
                {{{2.5216861867, -1.1341309882, -0.3875551985},
                  {-0.2764799142, 1.3727190877, -0.0962391734},
                  {-0.0153780650, -0.1529753359, 1.1683534008}}},
                1e-9);
}

}  // namespace
}  // namespace tessera::spectra
