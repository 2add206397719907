#include "measure/report/figure_text.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "measure/report/intervals.h"

namespace tessera::client {
namespace {

TEST(FigureText, HasTheDigitsThatItsErrorLetsItHave) {
  const struct {
    double value, error;
    const char* text;
  } cases[] = {{512.34, 0.83, "512.3 +- 0.8"},
               {512.34, 0.123, "512.34 +- 0.12"},
               {512.34, 0.0296, "512.34 +- 0.03"},
               {512.34, 0.0294, "512.340 +- 0.029"},
               {512.34, 0.096, "512.3 +- 0.1"},
               {512.34, 4.2, "512 +- 4"},
               {512.34, 42, "510 +- 40"},
               {51234, 230, "51230 +- 230"},
               {0.05, 0.4, "0.1 +- 0.4"},
               {-12.5, 0.03, "-12.50 +- 0.03"},
               {0, 0.002, "0.0000 +- 0.0020"},
               {5.1234e-6, 8.1e-9, "(5.123 +- 0.008)e-06"},
               {1.5e8, 2.2e6, "(1.500 +- 0.022)e+08"},
               {3e-7, 2e-5, "(0.0 +- 2.0)e-05"}};
  for (const auto& [value, error, text] : cases) EXPECT_EQ(with_error(value, error), text);
}

TEST(FigureText, WithoutAnErrorHasSixDigits) {
  EXPECT_EQ(with_error(4 * M_PI, 0), "12.5664");
  EXPECT_EQ(with_error(12566.370614, 0), "12566.4");
  EXPECT_EQ(with_error(100, 0), "100");
  EXPECT_EQ(with_error(0, 0), "0");
  EXPECT_EQ(with_error(-0.0, 0), "0");
  EXPECT_EQ(with_error(0.25, 0), "0.25");
  EXPECT_EQ(with_error(1234567890, 0), "1.23457e+09");
  EXPECT_EQ(with_error(1e-300, 0), "1e-300");
}

TEST(FigureText, TakesNumbersThatAreNone) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN(),
                   kInfinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(with_error(kNan, 1), "nan");
  EXPECT_EQ(with_error(-kInfinity, 0), "-inf");
  EXPECT_EQ(with_error(3, kInfinity), "3 +- inf");
  EXPECT_EQ(with_error(3, kNan), "3 +- nan");
  EXPECT_FALSE(with_error(std::numeric_limits<double>::max(), std::numeric_limits<double>::min()).empty());
  EXPECT_FALSE(with_error(std::numeric_limits<double>::denorm_min(), 1e300).empty());
}

TEST(FigureText, ShortestReadsAsTheSameNumber) {
  EXPECT_EQ(shortest_text(0.1), "0.1");
  EXPECT_EQ(shortest_text(1.0 / 3), "0.3333333333333333");
  for (const double value : {1e300, -4.9e-324, 123456789.125, M_PI})
    EXPECT_EQ(std::strtod(shortest_text(value).c_str(), nullptr), value);
}

// Quantiles of Student's t from published tables, which have four decimals.
TEST(Confidence, IntervalsAreStudents) {
  const ConfidenceInterval ten =
      confidence_95({.value = 5, .standard_error = 2, .samples = 11, .degrees_of_freedom = 10});
  EXPECT_NEAR(ten.low, 5 - 2 * 2.2281, 2 * 5e-5);
  EXPECT_NEAR(ten.high, 5 + 2 * 2.2281, 2 * 5e-5);
  const ConfidenceInterval known =
      confidence_95({.value = 0, .standard_error = 1, .samples = 1, .degrees_of_freedom = 0});
  EXPECT_NEAR(known.high, 1.9600, 1e-4) << "an error whose own is not told";
  const ConfidenceInterval exact = confidence_95({.value = 5});
  EXPECT_EQ(exact.low, 5);
  EXPECT_EQ(exact.high, 5);
}

TEST(Confidence, IsTheSameForManyFigures) {
  Intervals intervals;
  for (const double freedom : {3.0, 63.0, 3.0, 0.0}) {
    const Figure figure{.value = 7, .standard_error = 0.5, .samples = 9, .degrees_of_freedom = freedom};
    const ConfidenceInterval one = confidence_95(figure), of_many = intervals.of(figure);
    EXPECT_DOUBLE_EQ(of_many.low, one.low);
    EXPECT_DOUBLE_EQ(of_many.high, one.high);
  }
}

}  // namespace
}  // namespace tessera::client
