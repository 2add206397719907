// Pictures whose paths carry light of wavelengths, and the colours that they are to have.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <string>

#include "statistical/reference/lit_things.h"
#include "statistical/reference/picture.h"
#include "support/picture/measured_spectra.h"

namespace tessera::test {

inline constexpr const char *kSpectral = " color: COLOR_SPECTRAL ",
                            *kAlone = " path_sharing: PATH_SHARING_OFF ",
                            *kShared = " path_sharing: PATH_SHARING_4 ";

inline Pictures pictures_of(const std::string& scene, const std::string& integrator, std::uint32_t depth,
                            const std::string& settings, const TestBlobs& blobs = light_blobs(),
                            std::uint32_t spp_of_long_form = 2048) {
  PictureRequest request;
  request.scene = scene;
  request.integrator = integrator;
  request.max_depth = depth;
  request.settings = settings;
  request.spp = samples_of_form(spp_of_long_form);
  request.blobs = blobs;
  return measure_pictures(request);
}

/// One of the values or channels of each picture.
inline std::vector<Picture::Value> values_by_seed(const Pictures& pictures,
                                                  std::vector<Picture::Value> Picture::*values,
                                                  std::size_t index) {
  std::vector<Picture::Value> result;
  for (const Picture& picture : pictures) {
    EXPECT_LT(index, (picture.*values).size());
    if (index < (picture.*values).size()) result.push_back((picture.*values)[index]);
  }
  return result;
}

/// The mean over pictures that differ in their seeds.
inline Picture::Value mean_of(const std::vector<Picture::Value>& by_seed) {
  Picture::Value mean;
  const auto count = static_cast<double>(by_seed.size());
  for (const Picture::Value& value : by_seed) {
    mean.mean += value.mean / count;
    mean.error = std::hypot(mean.error, value.error / count);
  }
  return mean;
}

/// A value of pictures against one that is known. Fails where noise is more than `noise` of it.
inline Difference difference_from_known(const std::string& name, const std::vector<Picture::Value>& by_seed,
                                        double expected, double relative, double noise) {
  EXPECT_LT(mean_of(by_seed).error, noise * std::abs(expected) + 1e-12) << name << ": nothing can be told";
  return difference_from(name, by_seed, expected, relative);
}

/// Fails where the pictures differ, and where a difference of the part `seen` would not have been found.
inline void expect_agreement(const Pictures& a, const Pictures& b, double relative, double seen) {
  expect_same(a, b, relative);
  for (std::size_t c = 0; c < 3; ++c) {
    Pictures brighter = b;
    for (Picture& picture : brighter)
      for (std::size_t v = c; v < picture.values.size(); v += 3) picture.values[v].mean *= 1 + seen;
    EXPECT_LT(p_value_of(differences_of(a, brighter, relative)), 1e-4) << "channel " << c;
  }
}

/// Fails unless the whole picture has this colour, within its noise and a part of it.
inline void expect_color(const Pictures& pictures, const spectra::Triple& expected, double relative) {
  std::vector<Difference> differences;
  for (std::size_t c = 0; c < 3; ++c)
    differences.push_back(difference_from_known(absl::StrCat("channel ", c),
                                                values_by_seed(pictures, &Picture::values, c), expected[c],
                                                relative, 0.02));
  expect_none(differences);
}

}  // namespace tessera::test
