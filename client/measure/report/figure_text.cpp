#include "measure/report/figure_text.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "image/metrics.h"

namespace tessera::client {
namespace {

constexpr int kDigitsWithoutError = 6;
constexpr int kMostDigits = 15;  // decimal digits that a double keeps

int exponent_of(double value) { return static_cast<int>(std::floor(std::log10(std::abs(value)))); }

/// The decimal place, as a power of ten, to which an error is told.
int last_place(double error) {
  const int first = exponent_of(error);
  // 0.096 has one digit, which makes it 0.1.
  return error < 2.95 * std::pow(10.0, first)  ? first - 1
         : error < 9.5 * std::pow(10.0, first) ? first
                                               : first + 1;
}

bool needs_power(double value) {
  const double size = std::abs(value);
  return size != 0 && (size >= 1e7 || size < 1e-4);
}

/// Without a power, `place` decimals after the point or zeros before it.
std::string rounded(double value, int place) {
  if (place <= 0) return absl::StrFormat("%.*f", -place, value);
  const double unit = std::pow(10.0, place);
  return absl::StrFormat("%.0f", std::round(value / unit) * unit);
}

struct Mantissas {
  double value = 0, error = 0;
  int digits = 0;
  int exponent = 0;
};

/// Value and error over the power of ten that a large or small one is told with.
Mantissas mantissas_of(double value, double error) {
  const double size = std::max(std::abs(value), error);
  Mantissas of{.exponent = exponent_of(size)};
  const double unit = std::pow(10.0, of.exponent);
  of.value = value / unit, of.error = error / unit;
  of.digits = std::clamp(-last_place(of.error), 0, kMostDigits);
  return of;
}

bool has_error(double error) { return error > 0 && std::isfinite(error); }

}  // namespace

bool is_exact(const Figure& figure) { return figure.degrees_of_freedom == 0 && figure.standard_error == 0; }

ConfidenceInterval confidence_95(const Figure& figure) {
  if (is_exact(figure)) return {figure.value, figure.value};
  // An error that nothing tells how well it is known is taken for known.
  const double t = figure.degrees_of_freedom > 0 ? student_t_quantile(0.05, figure.degrees_of_freedom)
                                                 : student_t_quantile(0.05, 1e9);
  return {figure.value - t * figure.standard_error, figure.value + t * figure.standard_error};
}

FigureText figure_text(double value, double error) {
  if (!std::isfinite(value)) return {absl::StrFormat("%g", value), ""};
  if (!has_error(error)) return {short_text(value), error == 0 ? "" : absl::StrFormat("%g", error)};
  if (needs_power(std::max(std::abs(value), error))) {
    const Mantissas of = mantissas_of(value, error);
    const std::string power = absl::StrFormat("e%+03d", of.exponent);
    return {absl::StrCat(absl::StrFormat("%.*f", of.digits, of.value), power),
            absl::StrCat(absl::StrFormat("%.*f", of.digits, of.error), power)};
  }
  const int place = std::max(last_place(error), -kMostDigits);
  return {rounded(value, place), rounded(error, place)};
}

std::string with_error(double value, double error) {
  const FigureText text = figure_text(value, error);
  if (text.error.empty()) return text.value;
  const std::size_t power = text.value.find('e');
  if (power == std::string::npos || !has_error(error)) return absl::StrCat(text.value, " +- ", text.error);
  return absl::StrCat("(", text.value.substr(0, power), " +- ", text.error.substr(0, text.error.find('e')),
                      ")", text.value.substr(power));
}

std::string shortest_text(double value) {
  std::array<char, 32> buffer;
  const auto [end, error] = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  return error == std::errc{} ? std::string(buffer.data(), end) : std::string();
}

std::string short_text(double value) {
  if (value == 0 || !std::isfinite(value)) return absl::StrFormat("%g", value == 0 ? 0 : value);
  if (needs_power(value)) return absl::StrFormat("%.*g", kDigitsWithoutError, value);
  const int decimals = std::max(0, kDigitsWithoutError - 1 - exponent_of(value));
  std::string text = absl::StrFormat("%.*f", decimals, value);
  if (text.find('.') == std::string::npos) return text;
  while (text.back() == '0') text.pop_back();
  if (text.back() == '.') text.pop_back();
  return text;
}

std::string step_text(const MeasuredStep& step) {
  return step.sky == kNightWord ? absl::StrCat(short_text(step.value), " (", kNightWord, ")")
                                : short_text(step.value);
}

}  // namespace tessera::client
