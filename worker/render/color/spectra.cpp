// Compiled for kernels of wavelengths alone.
#include "render/color/spectra.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// The same as spectra::value(SigmoidCoefficients, nm), which cancels nowhere.
TESSERA_INLINE Float sigmoid_at(const Color& k, Float nm) {
  const Float t = clamp((nm - kSigmoidMiddleNm) * (1 / kSigmoidHalfWidthNm), -1.0f, 1.0f);
  // Beyond, floats have no difference to 0 and to 1 left; black is 0.
  constexpr float kMost = 1e9f;
  const Float x = clamp(fma(fma(k.c[0], t, k.c[1]), t, k.c[2]), -kMost, kMost);
  const Float root = sqrt(fma(x, x, Float(1.0f)));
  const Float low = select_or_zero(x > -kMost, 0.5f / (root * (root - x)));
  return select(x < 0.0f, low, fma(x * 0.5f, 1.0f / root, Float(0.5f)));
}

/// A place among the samples of curves: between `index` and the next.
struct CurvePlace {
  Int index;
  Float part;

  TESSERA_INLINE explicit CurvePlace(Float nm) {
    const Float place = clamp(nm - kFirstNm, 0.0f, static_cast<float>(kCurveSamples - 1));
    index = min(to_int(place), kCurveSamples - 2);
    part = place - to_float(index);
  }
};

TESSERA_INLINE Float curve_at(const float* curves, Int curve, const CurvePlace& place, Mask active) {
  const Int at = curve * kCurveSamples + place.index;
  return lerp(place.part, gather(curves, at, active), gather(curves + 1, at, active));
}

/// The cell that a number is in: the last of `cells` whose first node is not above it, or else the first.
/// Nodes ascend, kStride floats apart.
template <int kStride>
TESSERA_INLINE Int cell_of(const float* nodes, std::int32_t cells, Float number, Mask active) {
  Int low(0), high(cells);
  for (std::int32_t width = cells; width > 1; width = (width + 1) / 2) {
    const Int middle = shift_right<1>(low + high);
    const Mask below = (gather(nodes, middle * kStride, active) <= number) & (middle > low);
    low = select(below, middle, low), high = select(below, high, max(middle, low + 1));
  }
  return low;
}

/// Where numbers lie among ascending nodes: between two of them, or beyond the first or the last two.
struct NodeCell {
  Int low;
  Float weight_of_high;

  TESSERA_INLINE NodeCell(const std::vector<float>& nodes, Float number, Mask active)
      : low(cell_of<1>(nodes.data(), static_cast<std::int32_t>(nodes.size()) - 1, number, active)) {
    const Float from = gather(nodes.data(), low, active), to = gather(nodes.data(), low + 1, active);
    weight_of_high = (number - from) / (to - from);
  }
};

/// The same as spectra::SigmoidTable::look_up().
Color coefficients_of(const SpectralTables& tables, const Color& color, Mask active) {
  // Near white, the complement is looked up: the sigmoids of x and -x add up to 1.
  const Mask bright = min(min(color.c[0], color.c[1]), color.c[2]) > 0.5f;
  const Color v = select(bright, Color(1.0f) - color, color);
  const auto &r = v.c[0], &g = v.c[1], &b = v.c[2];
  const Mask red = (r >= g) & (r >= b), green = and_not(g >= b, red);
  const Float largest = max(v.max_component(), 1e-12f);
  const Float inverse = 1.0f / largest;
  const Float next = select(red, g, select(green, b, r)) * inverse,
              after_next = select(red, b, select(green, r, g)) * inverse;
  const Int plane = select(red, Int(0), select(green, Int(1), Int(2)));
  const NodeCell level(tables.levels, -1.0f / sqrt(largest), active), x(tables.ratios, after_next, active),
      y(tables.ratios, next, active);
  const auto n = static_cast<std::int32_t>(tables.ratios.size());
  const Int first = ((plane * n + level.low) * n + y.low) * n + x.low;
  const auto at = [&](std::int32_t up, std::int32_t along_next, std::int32_t along_after_next) {
    const Int index = first + (up * n + along_next) * n + along_after_next;
    const Float4 row = gather4(tables.coefficients, index * 4, active);
    return color_of([&](int i) { return row.c[i]; });
  };
  const auto on_level = [&](std::int32_t up) {
    return lerp(y.weight_of_high, lerp(x.weight_of_high, at(up, 0, 0), at(up, 0, 1)),
                lerp(x.weight_of_high, at(up, 1, 0), at(up, 1, 1)));
  };
  const Color found = lerp(level.weight_of_high, on_level(0), on_level(1));
  return select(bright, found * -1.0f, found);
}

}  // namespace

LaneResponse lane_response(const SensitivityTable& sensor, const std::vector<float>& response,
                           const Wavelengths& wavelengths) {
  LaneResponse result;
  const auto count = static_cast<std::int32_t>(sensor.quantiles.size());
  const float* const first = &sensor.quantiles.data()->nm;
  for (int i = 0; i < kSpectrumLanes; ++i) {
    const Float nm = wavelengths.c[i];
    // The width of its quantile is one over the density there, but for their number.
    const Int quantile = cell_of<2>(first, count, nm, Mask::all());
    result.weight[i] =
        gather(first + 1, quantile * 2, Mask::all()) * (static_cast<float>(count) / kSpectrumLanes);
    const Mask seen = (nm >= sensor.from_nm) & (nm <= sensor.to_nm);
    const Float weight = select_or_zero(seen, result.weight[i]);
    const CurvePlace place(nm);
    const Float4 here = gather4(response.data(), place.index * 4, Mask::all()),
                 next = gather4(response.data(), place.index * 4 + 4, Mask::all());
    result.color[i] =
        color_of([&](int band) { return lerp(place.part, here.c[band], next.c[band]) * weight; });
  }
  return result;
}

Spectrum Spectra::constant(const Color& coefficients, Int curve, Mask active) const {
  Spectrum result;
  const Mask curved = active & (curve >= 0);
  for (int i = 0; i < kSpectrumLanes; ++i) result.c[i] = sigmoid_at(coefficients, wavelengths_.c[i]);
  return none(curved) ? result : select(curved, this->curve(curve, curved), result);
}

Spectrum Spectra::curve(Int number, Mask active) const {
  Spectrum result;
  for (int i = 0; i < kSpectrumLanes; ++i)
    result.c[i] = curve_at(tables_->curves.data(), number, CurvePlace(wavelengths_.c[i]), active);
  return result;
}

Spectrum Spectra::factor(const Color& color, Mask active) const {
  const Color positive = max(color, 0.0f);
  const Float largest = positive.max_component();
  // Factors above 1 are twice as large as the sigmoid: half of the light is smoother than all of it.
  return scaled(positive, select(largest > 1.0f, largest * 2.0f, 1.0f), active);
}

Spectrum Spectra::density(const Color& color, Mask active) const {
  const Color positive = max(color, 0.0f);
  const Float largest = positive.max_component();
  return scaled(positive, select(largest > 0.0f, largest * 2.0f, 1.0f), active);
}

Spectrum Spectra::scaled(const Color& positive, Float scale, Mask active) const {
  const Mask grey = (positive.c[0] == positive.c[1]) & (positive.c[1] == positive.c[2]);
  if (none(and_not(active, grey))) return Spectrum(positive.c[0]);
  const Color coefficients = coefficients_of(*tables_, positive * (1.0f / scale), active);
  Spectrum result;
  for (int i = 0; i < kSpectrumLanes; ++i)
    result.c[i] = select(grey, positive.c[0], sigmoid_at(coefficients, wavelengths_.c[i]) * scale);
  return result;
}

Spectrum Spectra::light(const Color& color, Int curve, Mask active) const {
  Spectrum result = factor(color, active);
  const Int lamp = max(curve, 0);
  for (int i = 0; i < kSpectrumLanes; ++i)
    result.c[i] = result.c[i] * curve_at(tables_->curves.data(), lamp, CurvePlace(wavelengths_.c[i]), active);
  return result;
}

}  // namespace tessera::render::TESSERA_ISA
