#include "import/pbrt/file/color_space.h"

namespace tessera::client::pbrt {
namespace {

using Matrix3 = double[3][3];

// Derived from the primaries (DCI-P3 with the D65 white, as pbrt-v4 has it; BT.2020; AP0) and the white
// points of the spaces: M = Rec709_from_XYZ * Bradford(white to D65) * XYZ_from_space, each row summing to 1.
constexpr Matrix3 kFromDciP3 = {{1.2249401763, -0.2249401763, 0.0},
                                {-0.0420569547, 1.0420569547, 0.0},
                                {-0.0196375546, -0.0786360456, 1.0982736001}};
constexpr Matrix3 kFromRec2020 = {{1.6604910021, -0.5876411388, -0.0728498633},
                                  {-0.1245504745, 1.1328998971, -0.0083494226},
                                  {-0.0181507634, -0.1005788980, 1.1187296614}};
constexpr Matrix3 kFromAces2065 = {{2.5216861867, -1.1341309882, -0.3875551985},
                                   {-0.2764799142, 1.3727190877, -0.0962391734},
                                   {-0.0153780650, -0.1529753359, 1.1683534008}};

}  // namespace

std::optional<ColorSpace> color_space_of(std::string_view name) {
  if (name == "srgb") return ColorSpace::kSrgb;
  if (name == "dci-p3") return ColorSpace::kDciP3;
  if (name == "rec2020") return ColorSpace::kRec2020;
  if (name == "aces2065-1") return ColorSpace::kAces2065;
  return std::nullopt;
}

std::array<double, 3> rec709_from(ColorSpace from, const std::array<double, 3>& rgb) {
  if (from == ColorSpace::kSrgb) return rgb;
  const Matrix3& m = from == ColorSpace::kDciP3     ? kFromDciP3
                     : from == ColorSpace::kRec2020 ? kFromRec2020
                                                    : kFromAces2065;
  std::array<double, 3> result;
  for (int r = 0; r < 3; ++r) result[r] = m[r][0] * rgb[0] + m[r][1] * rgb[1] + m[r][2] * rgb[2];
  return result;
}

}  // namespace tessera::client::pbrt
