// P-values of tests that allow for a known systematic error, and ways to combine p-values.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <span>
#include <vector>

#include "support/kernel/chi2.h"

namespace tessera::test {

/// Probability that a standard normal variable exceeds `z`.
inline double normal_tail(double z) { return 0.5 * std::erfc(z / std::sqrt(2.0)); }

/// The z that a standard normal variable exceeds with probability `tail` in (0, 0.5], by bisection.
inline double normal_quantile(double tail) {
  double low = 0, high = 40;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (normal_tail(middle) > tail ? low : high) = middle;
  }
  return low;
}

/// Probability that a variable of Student's t distribution exceeds `t` [Abramowitz & Stegun 1964, 26.7.3 and
/// 26.7.4].
inline double student_tail(double t, int degrees_of_freedom) {
  if (t < 0) return 1 - student_tail(-t, degrees_of_freedom);
  const double theta = std::atan(t / std::sqrt(static_cast<double>(degrees_of_freedom)));
  const double cosine = std::cos(theta);
  const bool odd = degrees_of_freedom % 2 == 1;
  double sum = 0, term = odd ? cosine : 1;
  for (int k = odd ? 1 : 0; k + 2 <= degrees_of_freedom; k += 2) {
    sum += term;
    term *= (k + 1.0) / (k + 2.0) * cosine * cosine;
  }
  const double within = odd ? (theta + std::sin(theta) * sum) * 2 / M_PI : std::sin(theta) * sum;
  return std::max(0.0, (1 - within) / 2);
}

/// The sum of both tails of a distribution about an interval, from a value that far from its middle on.
template <class Tail>
double tails_about(double difference, double allowed, double standard_error, Tail&& tail) {
  const double distance = std::abs(difference);
  if (!(standard_error > 0)) return distance <= allowed ? 1 : 0;
  return tail((distance - allowed) / standard_error) + tail((distance + allowed) / standard_error);
}

/// Tests that the mean of a normal variable lies within [-allowed, allowed], given one value of it,
/// `difference`, and its standard error [Lehmann & Romano 2005, sec. 3.7]: the largest probability, among
/// these means, of a value that far from zero. Uniform in [0, 1] where the mean is `allowed` itself; without
/// noise, 0 or 1.
inline double interval_p_value(double difference, double allowed, double standard_error) {
  return tails_about(difference, allowed, standard_error, normal_tail);
}
/// The same where the standard error was measured, with so many degrees of freedom.
inline double interval_p_value(double difference, double allowed, double standard_error,
                               int degrees_of_freedom) {
  return tails_about(difference, allowed, standard_error,
                     [=](double t) { return student_tail(t, degrees_of_freedom); });
}

/// Probability that `trials` independent events of probability `p` happen at least `count` times.
inline double binomial_tail(std::size_t count, std::size_t trials, double p) {
  if (count == 0) return 1;
  const auto n = static_cast<double>(trials);
  double sum = 0;
  for (std::size_t k = count; k <= trials; ++k) {
    const auto x = static_cast<double>(k);
    const double term = std::exp(std::lgamma(n + 1) - std::lgamma(x + 1) - std::lgamma(n - x + 1) +
                                 x * std::log(p) + (n - x) * std::log1p(-p));
    sum += term;
    if (x > n * p && term < 1e-17 * sum) break;
  }
  return std::min(sum, 1.0);
}

/// One p-value from those of independent tests of the same hypothesis [Fisher 1925].
inline double fisher_p_value(std::span<const double> p_values) {
  double half_statistic = 0;
  for (const double p : p_values) half_statistic -= std::log(std::max(p, 1e-300));
  return regularized_gamma_q(static_cast<double>(p_values.size()), half_statistic);
}

/// P-values of several hypotheses, adjusted so that those below a level may be rejected with that probability
/// of rejecting any one wrongly, however they depend on one another [Holm 1979].
inline std::vector<double> holm_adjusted(std::span<const double> p_values) {
  std::vector<std::size_t> order(p_values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return p_values[a] < p_values[b]; });
  std::vector<double> adjusted(p_values.size());
  double largest = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    largest = std::max(largest, static_cast<double>(order.size() - i) * p_values[order[i]]);
    adjusted[order[i]] = std::min(largest, 1.0);
  }
  return adjusted;
}

}  // namespace tessera::test
