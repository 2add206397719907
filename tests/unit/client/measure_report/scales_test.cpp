// Scales of values and of colours.
#include <gmock/gmock.h>

#include <cmath>
#include <regex>

#include "absl/strings/str_replace.h"
#include "plot/color_map.h"
#include "plot/value_scale.h"
#include "unit/client/files.h"

namespace tessera::client {
namespace {

std::vector<std::string> labels_of(const ValueScale& scale, int wanted = 6) {
  std::vector<std::string> labels;
  for (const ScaleTick& tick : ticks_on(scale, wanted)) labels.push_back(tick.label);
  return labels;
}

TEST(ValueScale, TicksAreRound) {
  constexpr ScaleKind kLinear = ScaleKind::kLinear, kLog = ScaleKind::kLogarithmic;
  EXPECT_THAT(labels_of({kLinear, 0, 500}), testing::ElementsAre("0", "100", "200", "300", "400", "500"));
  EXPECT_THAT(labels_of({kLinear, -0.3, 0.35}), testing::ElementsAre("-0.2", "0", "0.2"));
  EXPECT_THAT(labels_of({kLinear, 0, 24000}),
              testing::ElementsAre("0", "5000", "10\u202f000", "15\u202f000", "20\u202f000"));
  EXPECT_THAT(labels_of({kLog, 0.1, 1000}), testing::ElementsAre("0.1", "1", "10", "100", "1000"));
  EXPECT_THAT(labels_of({kLog, 2, 500}),
              testing::ElementsAre("2", "5", "10", "20", "50", "100", "200", "500"));
  EXPECT_THAT(labels_of({kLog, 1e-6, 1e6}), testing::ElementsAre("10\u207b\u2076", "10\u207b\u2074", "0.01",
                                                                 "1", "100", "10\u202f000", "10\u2076"));
  EXPECT_THAT(labels_of({kLinear, 0, 3e7}, 3),
              testing::ElementsAre("0", "10\u2077", "2\u00b710\u2077", "3\u00b710\u2077"));
}

/// The number that a label says.
double number_of(std::string label) {
  static const char* const kDigits[] = {"\u2070", "\u00b9", "\u00b2", "\u00b3", "\u2074",
                                        "\u2075", "\u2076", "\u2077", "\u2078", "\u2079"};
  label = absl::StrReplaceAll(label, {{"\u202f", ""}});
  const std::size_t power =
      label.find("10", label.find("\u00b7") == std::string::npos ? 0 : label.find("\u00b7"));
  if (label.size() < 4 || power == std::string::npos ||
      label.find_first_not_of("0123456789-.") == std::string::npos)
    return std::stod(label);
  const std::size_t dot = label.find("\u00b7");
  const double base = dot == std::string::npos ? (label[0] == '-' ? -1 : 1) : std::stod(label.substr(0, dot));
  std::string exponent = absl::StrReplaceAll(label.substr(power + 2), {{"\u207b", "-"}});
  for (int digit = 0; digit < 10; ++digit)
    exponent = absl::StrReplaceAll(exponent, {{kDigits[digit], std::to_string(digit)}});
  return base * std::pow(10, std::stoi(exponent));
}

TEST(ValueScale, LabelsSayTheirValues) {
  int seen = 0;
  for (int exponent = -12; exponent <= 12; ++exponent) {
    for (const double low : {0.0, 0.13, -0.7, 2.3}) {
      for (const double length : {1.0, 1.7, 3.3, 8.0}) {
        const double unit = std::pow(10, exponent);
        const ValueScale scale{ScaleKind::kLinear, low * unit, (low + length) * unit};
        const std::vector<ScaleTick> ticks = ticks_on(scale);
        EXPECT_GE(ticks.size(), 2u);
        EXPECT_LE(ticks.size(), 8u);
        const double step = ticks[1].value - ticks[0].value;
        for (std::size_t i = 0; i < ticks.size(); ++i, ++seen) {
          EXPECT_NEAR(scale.place(ticks[i].value), 0.5, 0.5 + 1e-6) << "within the scale";
          EXPECT_NEAR(ticks[i].value, ticks[0].value + static_cast<double>(i) * step, 1e-9 * step);
          EXPECT_NEAR(number_of(ticks[i].label), ticks[i].value, 1e-6 * step) << ticks[i].label;
        }
        const double digit = step / std::pow(10, std::floor(std::log10(step) + 1e-9));
        EXPECT_NEAR(std::abs(digit - 1) * std::abs(digit - 2) * std::abs(digit - 5), 0, 1e-6) << step;
      }
    }
  }
  EXPECT_GT(seen, 1000);
}

TEST(ValueScale, CoversTheValuesWithRoundEnds) {
  const auto linear = [](std::vector<double> values) { return scale_over(values, ScaleKind::kLinear); };
  EXPECT_EQ(linear({3, 487}).low, 0);
  EXPECT_EQ(linear({3, 487}).high, 500);
  EXPECT_EQ(linear({310, 320}).low, 310) << "values that are close to each other are told apart";
  EXPECT_EQ(linear({-3, 4}).low, -3);
  EXPECT_EQ(linear({7, 7, 7}).low, 0);
  EXPECT_EQ(linear({}).high, 1);
  EXPECT_EQ(linear({0, 0}).high, 1);
  EXPECT_EQ(linear({NAN, INFINITY, 5}).high, 5);
  const auto logarithmic = [](std::vector<double> values) {
    return scale_over(values, ScaleKind::kLogarithmic);
  };
  EXPECT_EQ(logarithmic({0.3, 700}).low, 0.2);
  EXPECT_EQ(logarithmic({0.3, 700}).high, 1000);
  EXPECT_DOUBLE_EQ(logarithmic({1e-20, 1000}).low, 1e-3) << "six decades";
  EXPECT_GT(logarithmic({0, -3}).low, 0);
  EXPECT_GT(logarithmic({5}).high, logarithmic({5}).low);
  std::vector<double> values(1000, 1);
  values[0] = 1e6, values[1] = 2;
  EXPECT_EQ(scale_over(values, ScaleKind::kLinear, {}, 0.002).high, 1) << "the two largest are left out";
  values[3] = 1e-9;
  EXPECT_EQ(scale_over(values, ScaleKind::kLogarithmic, {}, 0.002).low, 0.1) << "so is the smallest";
  EXPECT_EQ(scale_over(values, ScaleKind::kLinear, ValueRange{2, 3}).low, 2);
}

TEST(ValueScale, PlacesAndValuesAreInverse) {
  for (const ValueScale& scale :
       {ValueScale{ScaleKind::kLinear, -3, 9}, {ScaleKind::kLogarithmic, 0.1, 1e4}}) {
    EXPECT_DOUBLE_EQ(scale.place(scale.low), 0);
    EXPECT_DOUBLE_EQ(scale.place(scale.high), 1);
    EXPECT_NEAR(scale.place(scale.value(0.37)), 0.37, 1e-12);
    EXPECT_TRUE(std::isnan(scale.place(NAN)));
  }
  EXPECT_LT((ValueScale{ScaleKind::kLogarithmic, 0.1, 1e4}).place(0), 0);
}

TEST(ColorMaps, GrowBrighter) {
  for (const ColorMap map : {ColorMap::kCividis, ColorMap::kViridis, ColorMap::kGrey}) {
    double before = -1;
    for (int i = 0; i <= 64; ++i) {
      const double luminance = luminance_of(map_color(map, i / 64.0));
      EXPECT_GT(luminance, before) << "map " << static_cast<int>(map) << ", place " << i / 64.0;
      before = luminance;
    }
  }
}

// Who lacks the cones for long or medium waves sees colours that differ from blue to yellow and in lightness
// [Vienot1999]: red and green of linear sRGB are replaced by one mixture of both.
TEST(ColorMaps, CividisLooksAlikeWithoutRedAndGreen) {
  const auto linear = [](std::uint8_t code) {
    const double value = code / 255.0;
    return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
  };
  const auto coded = [](double value) {
    return 255 * (value <= 0.0031308 ? 12.92 * value : 1.055 * std::pow(value, 1 / 2.4) - 0.055);
  };
  for (int i = 0; i <= 64; ++i) {
    const PageColor color = map_color(ColorMap::kCividis, i / 64.0);
    const double r = linear(color[0]), g = linear(color[1]);
    for (const double red : {0.11238, 0.29275}) {  // protanopia, deuteranopia
      const double seen = coded(red * r + (1 - red) * g);
      // The green that such eyes see differs by few of 255 codes from what others see; a map from
      // red to green has ends that are 100 codes and more apart for some, and alike for others.
      EXPECT_NEAR(seen, color[1], 10) << i;
    }
  }
}

TEST(ColorMaps, AreKnownByName) {
  EXPECT_EQ(*color_map_of("viridis"), ColorMap::kViridis);
  EXPECT_THAT(std::string(color_map_of("cividiss").status().message()),
              testing::HasSubstr("did you mean 'cividis'?"));
  EXPECT_EQ(map_color(ColorMap::kCividis, -3), map_color(ColorMap::kCividis, 0));
  EXPECT_EQ(map_color(ColorMap::kGrey, 3), map_color(ColorMap::kGrey, 1));
  EXPECT_EQ(map_color(ColorMap::kCividis, NAN), kMissingColor);
}

TEST(ColorMaps, LettersAreReadOnThem) {
  for (const ColorMap map : {ColorMap::kCividis, ColorMap::kViridis, ColorMap::kGrey}) {
    for (int i = 0; i <= 32; ++i) {
      const PageColor color = map_color(map, i / 32.0);
      const double a = luminance_of(color), b = luminance_of(contrast_to(color));
      EXPECT_GE((std::max(a, b) + 0.05) / (std::min(a, b) + 0.05), 4.5) << "WCAG 2.1, level AA";
    }
  }
}

TEST(ColorMaps, TheWebPageHasTheSameCividis) {
  const std::string script = read_bytes("server/service/web/pages/false_color.js");
  std::smatch found;
  ASSERT_TRUE(std::regex_search(script, found, std::regex("kCividisKnots = \\[([0-9,\\s]+)\\]")));
  const std::string numbers = found[1];
  const std::regex number("[0-9]+");
  std::vector<int> knots;
  for (auto at = std::sregex_iterator(numbers.begin(), numbers.end(), number); at != std::sregex_iterator();
       ++at)
    knots.push_back(std::stoi(at->str()));
  ASSERT_EQ(knots.size(), 33 * 3u);
  for (std::size_t i = 0; i < 33; ++i) {
    const PageColor color = map_color(ColorMap::kCividis, static_cast<double>(i) / 32);
    for (std::size_t c = 0; c < 3; ++c) EXPECT_EQ(knots[3 * i + c], color[c]) << i;
  }
}

}  // namespace
}  // namespace tessera::client
