#include "spectra/curve.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

namespace tessera::spectra {
namespace {

using testing::HasSubstr;

TEST(Curve, IsLinearBetweenAndConstantBeyond) {
  const Curve curve{{400, 500, 700}, {1, 3, 2}};
  EXPECT_EQ(curve.at(300), 1);
  EXPECT_EQ(curve.at(400), 1);
  EXPECT_EQ(curve.at(450), 2);
  EXPECT_EQ(curve.at(600), 2.5);
  EXPECT_EQ(curve.at(900), 2);
  EXPECT_EQ(Curve{}.at(500), 0);
  // Two values at one wavelength: a step.
  EXPECT_EQ((Curve{{400, 500, 500, 600}, {1, 1, 3, 3}}.at(500)), 3);
}

TEST(Curve, IsRefusedWithItsFault) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN(),
                  kInf = std::numeric_limits<float>::infinity();
  EXPECT_TRUE(check_curve({{400, 500}, {1, 2}}).ok());
  EXPECT_TRUE(check_curve({{400}, {1}}).ok());
  const auto refusal = [](const Curve& curve) { return std::string(check_curve(curve).message()); };
  EXPECT_EQ(refusal({}), "a spectrum needs one value a wavelength, and at least one");
  EXPECT_EQ(refusal({{400, 500}, {1}}),
            "a spectrum needs one value a wavelength, but has 2 wavelengths and 1 values");
  EXPECT_EQ(refusal({{500, 400}, {1, 2}}),
            "wavelengths of a spectrum must ascend, but 400 nm follows 500 nm");
  EXPECT_THAT(refusal({{400, 400}, {1, 2}}), HasSubstr("400 nm follows 400 nm"));
  EXPECT_EQ(refusal({{400, kNan, 500}, {1, 2, 3}}), "wavelength 1 of a spectrum is not finite");
  EXPECT_EQ(refusal({{400, 500}, {1, kInf}}), "the value of a spectrum at 500 nm is not finite");
  EXPECT_EQ(refusal({{400, 500}, {kNan, 1}}), "the value of a spectrum at 400 nm is not finite");
}

}  // namespace
}  // namespace tessera::spectra
