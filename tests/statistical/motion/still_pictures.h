// Pictures of what moves, against the mean of many still ones.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "statistical/reference/picture.h"
#include "support/long_form.h"

namespace tessera::test {

/// A placement that turns about z, stretches along the axes and shifts, each at constant speed.
struct Placing {
  double degrees = 0;
  double stretch[3] = {1, 1, 1};
  double at[3] = {0, 0, 0};
};

inline Placing between(const Placing& a, const Placing& b, double t) {
  Placing result;
  result.degrees = (1 - t) * a.degrees + t * b.degrees;
  for (int i = 0; i < 3; ++i) {
    result.stretch[i] = (1 - t) * a.stretch[i] + t * b.stretch[i];
    result.at[i] = (1 - t) * a.at[i] + t * b.at[i];
  }
  return result;
}

/// "elements: [...]" of a v1::Matrix: first stretched, then turned, then shifted.
inline std::string matrix_of(const Placing& p) {
  const double angle = p.degrees * 3.14159265358979323846 / 180, c = std::cos(angle), s = std::sin(angle);
  return absl::StrFormat("elements: [%.15g,%.15g,0,%.15g, %.15g,%.15g,0,%.15g, 0,0,%.15g,%.15g, 0,0,0,1]",
                         c * p.stretch[0], -s * p.stretch[1], p.at[0], s * p.stretch[0], c * p.stretch[1],
                         p.at[1], p.stretch[2], p.at[2]);
}

/// "NAME { START } NAME_end { END }" of a moving thing, "NAME { PLACE }" of one that stands still at `time`.
inline std::string matrices(const std::string& name, const Placing& start, const Placing& end, double time) {
  return absl::StrCat(name, " { ", matrix_of(between(start, end, time)), " } ");
}
inline std::string matrices(const std::string& name, const Placing& start, const Placing& end) {
  return absl::StrCat(name, " { ", matrix_of(start), " } ", name, "_end { ", matrix_of(end), " } ");
}

/// The variance of a sum over parts of the time, each at a random moment of it: that of a value which changes
/// evenly within a part, by half of what it does from the part before to the one behind, is the square of
/// this over 12.
inline double variance_of_moments(const std::vector<double>& values) {
  double sum = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::size_t before = i > 0 ? i - 1 : i, behind = std::min(i + 1, values.size() - 1);
    const double change = (values[behind] - values[before]) / static_cast<double>(behind - before);
    sum += change * change / 12;
  }
  return sum;
}

/// The mean of 64 pictures for each seed, in the short form of 32, one at a random moment of each part of the
/// exposure: 256 in all, or 128.
inline Pictures mean_of_stills(const std::function<PictureRequest(double time)>& still) {
  constexpr int kSeeds = 4;
  const int parts = long_form() ? 64 : 32;
  std::mt19937 random(17);
  std::uniform_real_distribution<double> uniform(0, 1);
  Pictures result;
  for (int seed = 0; seed < kSeeds; ++seed) {
    Picture sum;
    std::vector<std::vector<double>> means;  // of each value, those of all parts
    for (int part = 0; part < parts; ++part) {
      PictureRequest request = still((part + uniform(random)) / parts);
      request.spp = 32;
      request.seed = static_cast<std::uint32_t>(1000 + seed * parts + part);
      const Picture picture = measure_picture(request);
      sum.values.resize(picture.values.size());
      means.resize(picture.values.size());
      for (std::size_t v = 0; v < picture.values.size(); ++v) {
        sum.values[v].mean += picture.values[v].mean / parts;
        sum.values[v].error = std::hypot(sum.values[v].error, picture.values[v].error / parts);
        means[v].push_back(picture.values[v].mean);
      }
    }
    for (std::size_t v = 0; v < means.size(); ++v)
      sum.values[v].error = std::hypot(sum.values[v].error, std::sqrt(variance_of_moments(means[v])) / parts);
    result.push_back(sum);
  }
  return result;
}

}  // namespace tessera::test
