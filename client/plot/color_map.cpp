#include "plot/color_map.h"

#include <algorithm>
#include <cmath>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "base/nearest_name.h"

namespace tessera::client {
namespace {

constexpr std::size_t kKnots = 33;
using Knots = std::array<PageColor, kKnots>;

/// Every eighth colour of the published tables of 256 [Nunez2018; Smith2015], whose authors let anybody use
/// them (viridis by CC0, cividis by the 2-clause BSD licence). Colours between are within 6 codes (cividis)
/// and 2 codes (viridis) of the tables' own.
constexpr Knots kCividisKnots{
    {{0, 34, 78},     {0, 40, 91},     {0, 46, 106},    {4, 51, 113},    {26, 56, 111},   {39, 62, 110},
     {50, 67, 109},   {59, 73, 108},   {67, 78, 108},   {75, 84, 108},   {82, 89, 109},   {90, 95, 110},
     {97, 101, 111},  {104, 106, 113}, {111, 112, 115}, {117, 118, 118}, {124, 123, 120}, {132, 129, 121},
     {139, 135, 120}, {147, 141, 120}, {155, 147, 118}, {163, 154, 117}, {171, 160, 114}, {179, 166, 112},
     {187, 173, 108}, {195, 180, 105}, {204, 186, 100}, {212, 193, 95},  {221, 201, 88},  {230, 208, 81},
     {239, 215, 72},  {248, 223, 60},  {254, 232, 56}}};
constexpr Knots kViridisKnots{{{68, 1, 84},    {71, 13, 96},   {72, 24, 106},  {72, 35, 116},  {71, 45, 123},
                               {69, 54, 129},  {66, 64, 134},  {63, 73, 137},  {59, 82, 139},  {55, 90, 141},
                               {51, 99, 141},  {47, 106, 142}, {44, 114, 142}, {41, 122, 142}, {38, 129, 142},
                               {35, 137, 142}, {33, 144, 140}, {31, 152, 139}, {31, 159, 136}, {33, 166, 133},
                               {40, 174, 128}, {49, 181, 123}, {62, 188, 116}, {76, 194, 108}, {93, 201, 99},
                               {110, 206, 88}, {130, 211, 76}, {150, 216, 63}, {171, 220, 50}, {192, 223, 36},
                               {213, 226, 26}, {234, 229, 26}, {253, 231, 37}}};

PageColor between(const Knots& knots, double place) {
  const double at = place * (kKnots - 1);
  const std::size_t knot = std::min(kKnots - 2, static_cast<std::size_t>(at));
  PageColor color;
  for (std::size_t c = 0; c < 3; ++c) {
    const double code =
        std::lerp(1.0 * knots[knot][c], 1.0 * knots[knot + 1][c], at - static_cast<double>(knot));
    color[c] = static_cast<std::uint8_t>(std::lround(code));
  }
  return color;
}

}  // namespace

PageColor map_color(ColorMap map, double place) {
  if (std::isnan(place)) return kMissingColor;
  place = std::clamp(place, 0.0, 1.0);
  if (map == ColorMap::kCividis) return between(kCividisKnots, place);
  if (map == ColorMap::kViridis) return between(kViridisKnots, place);
  // sRGB codes are about even in lightness; black and white are left to lines and letters.
  constexpr double kDarkest = 25, kBrightest = 240;
  const auto code = static_cast<std::uint8_t>(std::lround(std::lerp(kDarkest, kBrightest, place)));
  return {code, code, code};
}

const std::vector<std::string>& color_map_names() {
  static const std::vector<std::string> names = {"cividis", "viridis", "grey"};
  return names;
}

absl::StatusOr<ColorMap> color_map_of(const std::string& name) {
  const std::vector<std::string>& names = color_map_names();
  const auto found = std::ranges::find(names, name);
  if (found != names.end()) return static_cast<ColorMap>(found - names.begin());
  return absl::InvalidArgumentError(absl::StrCat("there is no map of colours \"", name, "\" but ",
                                                 absl::StrJoin(names, ", "),
                                                 base::did_you_mean(name, names)));
}

double luminance_of(const PageColor& color) {
  constexpr double kWeights[3] = {0.2126, 0.7152, 0.0722};
  double sum = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    const double code = color[c] / 255.0;
    sum += kWeights[c] * (code <= 0.04045 ? code / 12.92 : std::pow((code + 0.055) / 1.055, 2.4));
  }
  return sum;
}

PageColor contrast_to(const PageColor& color) {
  // Equal contrast (L1 + 0.05) / (L2 + 0.05) [WCAG 2.1] to black and white.
  const bool dark = luminance_of(color) < std::sqrt(0.05 * 1.05) - 0.05;
  return dark ? PageColor{255, 255, 255} : PageColor{0, 0, 0};
}

}  // namespace tessera::client
