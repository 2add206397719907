#include "plot/value_scale.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace tessera::client {
namespace {

constexpr double kMostDecades = 6;
/// Rounding of a value that ought to be a multiple of a step, in steps.
constexpr double kStepSlack = 1e-6;

/// The power of ten at or below a positive value.
double decade_of(double value) { return std::floor(std::log10(value) + 1e-12); }

/// 1, 2 or 5 times a power of ten, at least as large.
double round_up(double value) {
  const double decade = std::pow(10.0, decade_of(value)), digits = value / decade;
  constexpr double kRounding = 1 + 1e-9;
  for (const double round : {1.0, 2.0, 5.0}) {
    if (digits <= round * kRounding) return round * decade;
  }
  return 10 * decade;
}

double round_down(double value) {
  const double decade = std::pow(10.0, decade_of(value)), digits = value / decade;
  return (digits >= 5 ? 5 : digits >= 2 ? 2 : 1) * decade;
}

/// Digits of an exponent above the line.
std::string superscript(int exponent) {
  static constexpr const char* kDigits[] = {"\u2070", "\u00b9", "\u00b2", "\u00b3", "\u2074",
                                            "\u2075", "\u2076", "\u2077", "\u2078", "\u2079"};
  std::string text = exponent < 0 ? "\u207b" : "";
  for (const char digit : absl::StrCat(std::abs(exponent))) text += kDigits[digit - '0'];
  return text;
}

/// Groups of three digits before the decimal point, of numbers of five and more.
std::string grouped(std::string digits) {
  const std::size_t sign = digits.starts_with('-') ? 1 : 0;
  const std::size_t point = std::min(digits.find('.'), digits.size());
  if (point - sign < 5) return digits;
  for (std::size_t at = point; at > sign + 3;) digits.insert(at -= 3, "\u202f");
  return digits;
}

std::vector<ScaleTick> even_ticks(const ValueScale& scale, int wanted) {
  const double step = round_up((scale.high - scale.low) / std::max(wanted, 1));
  std::vector<ScaleTick> ticks;
  const double first = std::ceil(scale.low / step - kStepSlack),
               last = std::floor(scale.high / step + kStepSlack);
  // Ends that a step hardly changes have no ticks between them.
  if (!(last - first < 1000)) return ticks;
  for (double i = first; i <= last; ++i) ticks.push_back({i * step, tick_label(i * step, step)});
  return ticks;
}

std::vector<ScaleTick> decade_ticks(const ValueScale& scale, int wanted) {
  const double decades = std::log10(scale.high / scale.low);
  const bool few = 3 * decades <= 1.5 * wanted;
  const int stride = std::max(1, static_cast<int>(std::ceil(decades / std::max(wanted, 1))));
  std::vector<ScaleTick> ticks;
  for (int exponent = static_cast<int>(decade_of(scale.low)); exponent <= decade_of(scale.high); ++exponent) {
    if (exponent % stride != 0) continue;
    for (const double digit : {1.0, 2.0, 5.0}) {
      const double power = std::pow(10.0, exponent), value = digit * power;
      if ((digit > 1 && !few) || value < scale.low * (1 - 1e-9) || value > scale.high * (1 + 1e-9)) continue;
      ticks.push_back({value, tick_label(value, power)});
    }
  }
  return ticks;
}

ValueScale linear_over(double least, double most) {
  const double spread = most - least, size = std::max(std::abs(least), std::abs(most));
  // Values that are alike, or nearly, are shown from 0 on: their differences are rounding.
  if (!(spread > 1e-6 * size)) least = std::min(0.0, least), most = std::max(0.0, most);
  if (least == most) return {ScaleKind::kLinear, 0, 1};
  const bool far_from_zero = least > 0.6 * most;
  if (least > 0 && !far_from_zero) least = 0;
  const double step = round_up((most - least) / 10);
  ValueScale scale{ScaleKind::kLinear, step * std::floor(least / step + kStepSlack),
                   step * std::ceil(most / step - kStepSlack)};
  if (!(scale.high > scale.low)) scale.high = scale.low + step;
  return scale;
}

ValueScale logarithmic_over(double least, double most) {
  ValueScale scale{ScaleKind::kLogarithmic, 0.1, 1};
  if (!(most > 0)) return scale;
  scale.high = round_up(most);
  scale.low = round_down(std::max(least, scale.high * std::pow(10.0, -kMostDecades)));
  if (!(scale.high > scale.low)) scale.low = scale.high / 10;
  return scale;
}

}  // namespace

double ValueScale::place(double value) const {
  if (std::isnan(value)) return value;
  if (kind == ScaleKind::kLinear) return (value - low) / (high - low);
  return value > 0 ? std::log(value / low) / std::log(high / low) : -1;
}

double ValueScale::value(double place) const {
  return kind == ScaleKind::kLinear ? low + place * (high - low) : low * std::pow(high / low, place);
}

ValueScale scale_over(std::span<const double> values, ScaleKind kind, const std::optional<ValueRange>& range,
                      double cut) {
  if (range) return {kind, range->low, range->high};
  std::vector<double> known;
  for (const double value : values) {
    if (std::isfinite(value) && (kind == ScaleKind::kLinear || value > 0)) known.push_back(value);
  }
  if (known.empty()) return kind == ScaleKind::kLinear ? ValueScale{} : ValueScale{kind, 0.1, 1};
  const auto first = static_cast<std::ptrdiff_t>((kind == ScaleKind::kLogarithmic ? cut : 0) *
                                                 static_cast<double>(known.size() - 1));
  std::nth_element(known.begin(), known.begin() + first, known.end());
  const double least = known[static_cast<std::size_t>(first)];
  const auto last = static_cast<std::ptrdiff_t>((1 - cut) * static_cast<double>(known.size() - 1));
  std::nth_element(known.begin(), known.begin() + last, known.end());
  const double most = known[static_cast<std::size_t>(last)];
  return kind == ScaleKind::kLinear ? linear_over(least, most) : logarithmic_over(least, most);
}

std::vector<ScaleTick> ticks_on(const ValueScale& scale, int wanted) {
  std::vector<ScaleTick> ticks;
  if (scale.kind == ScaleKind::kLogarithmic) ticks = decade_ticks(scale, wanted);
  for (int finer = wanted; ticks.size() < 3 && finer <= 4 * wanted; finer += wanted) {
    std::vector<ScaleTick> even = even_ticks(scale, finer);
    if (even.size() > ticks.size()) ticks = std::move(even);
    if (ticks.size() >= 2) break;
  }
  return ticks;
}

std::string tick_label(double value, double step) {
  if (value == 0) return "0";  // minus zero, too
  if (!std::isfinite(value)) return absl::StrFormat("%g", value);
  const double size = std::abs(value);
  const int digits = std::max(0, -static_cast<int>(decade_of(step)));
  if (size < 1e6 && (size >= 0.001 || digits <= 3)) return grouped(absl::StrFormat("%.*f", digits, value));
  const int exponent = static_cast<int>(decade_of(size));
  const int kept = std::max(0, exponent - static_cast<int>(decade_of(step)));
  const std::string base = absl::StrFormat("%.*f", kept, value / std::pow(10.0, exponent));
  const std::string power = absl::StrCat("10", superscript(exponent));
  return base == "1" ? power : base == "-1" ? absl::StrCat("-", power) : absl::StrCat(base, "\u00b7", power);
}

}  // namespace tessera::client
