// Meters against truths: all figures of all cases together, by several seeds.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace tessera::test {

/// Pixels are floats, and so are tables of lights: sums of some tens of roundings of 6e-8.
inline constexpr double kRounding = 3e-6;
/// Shadow rays end before lights by a margin for rounding, by which places of lights seen from afar are off.
inline constexpr double kMargin = 3e-5;

struct MeasuredCase {
  std::string name = {};
  std::string scene = {};           // besides scene_with()'s
  std::string meters = {};          // in radiometric units, or others
  std::vector<double> truths = {};  // of all readings, one meter after the other
  std::string algorithm = "path";
  std::uint64_t samples = 1 << 15;  // of a seed; the long form takes 16 times as many
  std::string medium = {};
  bool is_spectral = false;
  double cd_per_m2 = 683;
  double rounding = kRounding;   // relative error that figures may have besides their own
  double largest_error = 0.004;  // relative standard error that the figures of a seed have at most
  std::vector<std::pair<std::string, std::string>> files = {};  // name and bytes, beside the scene
};

/// Measures all cases by several seeds, and expects the squares of all differences in standard errors to add
/// up to no more than chi-square does but once in 10,000 times, and none of them to be an outlier as rare.
/// With one case, 50 such tests fail by chance once in 100 runs of other seeds.
void expect_agreement(const std::vector<MeasuredCase>& cases);

}  // namespace tessera::test
