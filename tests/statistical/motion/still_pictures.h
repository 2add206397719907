// Pictures of what moves, against the mean of many still ones.
#pragma once

#include <gtest/gtest.h>

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

/// The mean of 64 pictures for each seed, one at a random moment of each 64th of the exposure: 256 in all.
/// What the random moments add to the noise of a seed is 1 / (64 sqrt(12 64)) = 6e-4 of all that changes, in
/// the short form of 32 pictures 1.6e-3.
inline Pictures mean_of_stills(const std::function<PictureRequest(double time)>& still) {
  constexpr int kSeeds = 4;
  const int parts = long_form() ? 64 : 32;
  std::mt19937 random(17);
  std::uniform_real_distribution<double> uniform(0, 1);
  Pictures result;
  for (std::uint32_t seed = 0; seed < kSeeds; ++seed) {
    Picture sum;
    for (int part = 0; part < parts; ++part) {
      PictureRequest request = still((part + uniform(random)) / parts);
      request.spp = 32;
      request.seed = 1000 + seed * static_cast<std::uint32_t>(parts) + static_cast<std::uint32_t>(part);
      const Picture picture = measure_picture(request);
      sum.values.resize(picture.values.size());
      for (std::size_t v = 0; v < picture.values.size(); ++v) {
        sum.values[v].mean += picture.values[v].mean / parts;
        sum.values[v].error = std::hypot(sum.values[v].error, picture.values[v].error / parts);
      }
    }
    result.push_back(sum);
  }
  return result;
}

}  // namespace tessera::test
