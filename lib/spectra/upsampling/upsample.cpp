#include "spectra/upsampling/upsample.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

#include "spectra/color/lab.h"
#include "spectra/color/rgb_space.h"
#include "spectra/rgb/scene_rgb.h"
#include "spectra/upsampling/fit.h"
#include "spectra/upsampling/own_table.h"
#include "spectra/upsampling/table.h"

namespace tessera::spectra {
namespace {

/// Into [lowest, highest]; NaN becomes 0.
Rgb into_range(const Rgb& rgb, float lowest, float highest) {
  const auto inside = [&](float v) { return v == v ? std::clamp(v, lowest, highest) : 0.0f; };
  return {inside(rgb.r), inside(rgb.g), inside(rgb.b)};
}

Lab lab_of_rec709(const Triple& rgb) {
  static const Matrix3 to_xyz = xyz_from_rgb(kRec709);
  static const Triple white = times(to_xyz, {1, 1, 1});
  return lab_of(times(to_xyz, rgb), white);
}

/// CIEDE2000 between a colour and that of a sigmoid under D65, a nanometre at a time.
double error_of(const Rgb& rgb, const SigmoidCoefficients& coefficients) {
  static const std::vector<ReflectanceShare> shares = reflectance_shares();
  Triple seen = {0, 0, 0};
  for (const ReflectanceShare& share : shares) {
    const double reflectance = value(coefficients, static_cast<float>(share.nm));
    for (std::size_t c = 0; c < 3; ++c) seen[c] += share.rgb[c] * reflectance;
  }
  return delta_e2000(lab_of_rec709({rgb.r, rgb.g, rgb.b}), lab_of_rec709(seen));
}

bool same(const Rgb& a, const Rgb& b) { return a.r == b.r && a.g == b.g && a.b == b.b; }

}  // namespace

const SigmoidTable& sigmoid_table() {
  static const SigmoidTable table(kOwnResolution, kOwnRows);
  return table;
}

UpsampledReflectance upsample_reflectance(const Rgb& rgb) {
  const Rgb inside = into_range(rgb, 0, 1), sought = into_range(rgb, -1, 2);
  const SigmoidCoefficients start = sigmoid_table().look_up(inside);
  if (same(inside, sought)) return {start, 0};
  const SigmoidFit fit = fit_sigmoid({sought.r, sought.g, sought.b}, {start.c0, start.c1, start.c2});
  const auto f = [](double v) { return static_cast<float>(v); };
  const SigmoidCoefficients fitted = {f(fit.coefficients[0]), f(fit.coefficients[1]), f(fit.coefficients[2])};
  // Neither may have it, and steep sigmoids are between the samples that the fit looks at.
  const double error = error_of(sought, fitted), error_of_start = error_of(sought, start);
  return error < error_of_start ? UpsampledReflectance{fitted, error}
                                : UpsampledReflectance{start, error_of_start};
}

UpsampledEmission upsample_emission(const Rgb& rgb) {
  const float most = std::numeric_limits<float>::max() / 2;
  const Rgb inside = into_range(rgb, -most, most);
  // Reflectances of half the light: brighter ones are less smooth.
  const float scale = 2 * std::max({inside.r, inside.g, inside.b});
  if (!(scale > 0)) return {0, constant_sigmoid(0.5f), 0};
  const auto [coefficients, error] =
      upsample_reflectance({inside.r / scale, inside.g / scale, inside.b / scale});
  return {scale, coefficients, error};
}

}  // namespace tessera::spectra
