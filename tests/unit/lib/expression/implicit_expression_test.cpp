// Functions of implicit surfaces: their grammar, their limits, their coefficients.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "expression/polynomial.h"

namespace tessera::expression {
namespace {

using testing::HasSubstr;

/// Runs a compiled program on plain numbers: what the kernels do 16 at a time.
double run(const Program& program, double x, double y, double z) {
  double r[kMaxRegisters] = {x, y, z};
  int last = 0;
  for (const Instruction& i : program.instructions) {
    const double a = r[i.from[0]], b = r[i.from[1]];
    double value = 0;
    switch (i.op) {
      case Op::kX:
      case Op::kY:
      case Op::kZ:
        value = a;
        break;
      case Op::kConstant:
        value = i.value;
        break;
      case Op::kAdd:
        value = a + b;
        break;
      case Op::kSubtract:
        value = a - b;
        break;
      case Op::kMultiply:
        value = a * b;
        break;
      case Op::kDivide:
        value = a / b;
        break;
      case Op::kNegate:
        value = -a;
        break;
      case Op::kPower:
        value = std::pow(a, i.power);
        break;
      case Op::kPow:
        value = a > 0 ? std::pow(a, b) : 0;
        break;
      case Op::kSqrt:
        value = std::sqrt(std::max(a, 0.0));
        break;
      case Op::kSin:
        value = std::sin(a);
        break;
      case Op::kCos:
        value = std::cos(a);
        break;
      case Op::kExp:
        value = std::exp(a);
        break;
      case Op::kLog:
        value = std::log(a);
        break;
      case Op::kAbs:
        value = std::abs(a);
        break;
      case Op::kMin:
        value = std::min(a, b);
        break;
      case Op::kMax:
        value = std::max(a, b);
        break;
      case Op::kNoise:
        value = 100 * a + 10 * b + r[i.from[2]];
        break;
    }
    r[i.target] = value;
    last = i.target;
  }
  return r[last];
}

double value_of(const std::string& text, double x = 2, double y = 3, double z = 5) {
  const auto parsed = parse(text);
  EXPECT_TRUE(parsed.ok()) << text << ": " << parsed.status();
  if (!parsed.ok()) return NAN;
  const auto program = compile(*parsed);
  EXPECT_TRUE(program.ok()) << text << ": " << program.status();
  return program.ok() ? run(*program, x, y, z) : NAN;
}

std::string error_of(const std::string& text) {
  const auto parsed = parse(text);
  return parsed.ok() ? "" : std::string(parsed.status().message());
}

TEST(ImplicitExpression, BindsAsMathematicsDoes) {
  EXPECT_EQ(value_of("x + y * z"), 17);
  EXPECT_EQ(value_of("x - y - z"), -6);
  EXPECT_EQ(value_of("x / y / z"), 2.0 / 3 / 5);
  EXPECT_EQ(value_of("-x^2"), -4);
  EXPECT_EQ(value_of("x^y^2"), 512);
  EXPECT_EQ(value_of("x^-1"), 0.5);
  EXPECT_EQ(value_of("-x * -y"), 6);
  EXPECT_EQ(value_of("x * (y + z)"), 16);
  EXPECT_EQ(value_of("x = y"), -1);
  EXPECT_EQ(value_of("x"), 2);
  EXPECT_EQ(value_of("1.5e1 + .5"), 15.5);
}

TEST(ImplicitExpression, KnowsItsFunctions) {
  EXPECT_EQ(value_of("min(z, x, y) + max(x, y, z)"), 7);
  EXPECT_EQ(value_of("abs(x - z) + sqrt(x + x)"), 5);
  EXPECT_EQ(value_of("sin(pi) + cos(x)"), std::sin(M_PI) + std::cos(2.0));
  EXPECT_EQ(value_of("exp(log(x))"), std::exp(std::log(2.0)));
  EXPECT_EQ(value_of("pow(x, 0.5) + pow(-x, 2) + pow(-x, 0.5)"), std::pow(2, 0.5) + 4);
  EXPECT_EQ(value_of("noise(x, y, z) + noise(x, x, 1)"), 235 + 221);
}

TEST(ImplicitExpression, NamesTheColumnOfAnError) {
  EXPECT_THAT(error_of("x +"), HasSubstr("column 4: the expression ends"));
  EXPECT_THAT(error_of("x + $"), HasSubstr("column 5: '$'"));
  EXPECT_THAT(error_of("x y"), HasSubstr("column 3: 'y' is unknown here; an operator or the end"));
  EXPECT_THAT(error_of("(x"), HasSubstr("column 3"));
  EXPECT_THAT(error_of("2 * tan(x)"), HasSubstr("column 5: 'tan' is unknown"));
  EXPECT_THAT(error_of("sqrt(x, y)"), HasSubstr("sqrt takes 1 argument"));
  EXPECT_THAT(error_of("max(x)"), HasSubstr("max takes 2 arguments or more"));
  EXPECT_THAT(error_of("noise(x, y)"), HasSubstr("noise takes 3 arguments"));
  EXPECT_THAT(error_of("1e999"), HasSubstr("column 1: a number that is finite"));
  EXPECT_THAT(error_of("x + 1/0"), HasSubstr("not finite"));
  EXPECT_THAT(error_of("x^65"), HasSubstr("a whole exponent beyond 64"));
  EXPECT_THAT(error_of(""), HasSubstr("column 1"));
  EXPECT_THAT(error_of(std::string("x\0", 2)), HasSubstr("column 2"));
}

TEST(ImplicitExpression, RefusesWhatIsTooLarge) {
  std::string terms = "x";
  for (int i = 0; i < 1'000'000; ++i) terms += "+x";
  EXPECT_THAT(error_of(terms), HasSubstr("column 32769: more than 32768 characters"));
  terms = "x";
  for (int i = 0; i < 3000; ++i) terms += "*" + std::to_string(i + 2);
  EXPECT_THAT(error_of(terms), HasSubstr("more than 2048 operations"));
  EXPECT_THAT(error_of(std::string(10'000, '(') + "x"), HasSubstr("column 65: nested more than 64 deep"));
  EXPECT_THAT(error_of(std::string(10'000, '-') + "x"), HasSubstr("column 65: nested more than 64 deep"));
  // Values that are all needed at the end.
  std::string sum = "0", product = "1";
  for (int i = 0; i < 70; ++i) {
    const std::string value = "sin(" + std::to_string(i + 2) + "*x)";
    sum += "+" + value, product += "*" + value;
  }
  const auto parsed = parse(sum + " = " + product);
  ASSERT_TRUE(parsed.ok()) << parsed.status();
  EXPECT_THAT(compile(*parsed).status().message(), HasSubstr("more than 64 values at once"));
}

TEST(ImplicitExpression, EqualPartsAreComputedOnce) {
  const auto parsed = parse("(x+y)^2 + (x+y)^2 + sin(x+y)");
  ASSERT_TRUE(parsed.ok());
  EXPECT_EQ(compile(*parsed)->instructions.size(), 5u);  // sum, square, sum, sine, sum
}

TEST(ImplicitExpression, PolynomialsAreMultipliedOut) {
  const auto polynomial = [](const std::string& text) { return expand(*parse(text)); };
  const auto heart = polynomial("(x^2 + 9/4*y^2 + z^2 - 1)^3 - x^2*z^3 - 9/80*y^2*z^3");
  ASSERT_TRUE(heart.has_value());
  EXPECT_EQ(heart->degree, 6);
  EXPECT_EQ(heart->at(0, 0, 0), -1);
  EXPECT_EQ(heart->at(6, 0, 0), 1);
  EXPECT_EQ(heart->at(2, 2, 0), -13.5);  // 3 * 2 * 9/4 * -1
  EXPECT_EQ(heart->at(2, 0, 3), -1);
  EXPECT_EQ(heart->at(0, 2, 3), -9.0 / 80);
  EXPECT_EQ(polynomial("(x+y+z)^12")->at(4, 4, 4), 34650);
  EXPECT_EQ(polynomial("x^3 - x*x*x + y")->degree, 1);
  EXPECT_EQ(polynomial("2 - 1")->degree, 0);
  EXPECT_FALSE(polynomial("x^13").has_value());
  EXPECT_FALSE(polynomial("x^7 * y^6").has_value());
  EXPECT_FALSE(polynomial("x / y").has_value());
  EXPECT_FALSE(polynomial("abs(x)").has_value());
  EXPECT_FALSE(polynomial("x^-1").has_value());
  EXPECT_EQ(polynomial("x / 4")->at(1, 0, 0), 0.25);
}

}  // namespace
}  // namespace tessera::expression
