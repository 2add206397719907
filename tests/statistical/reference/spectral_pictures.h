// Pictures whose paths carry light of wavelengths, and the colours that they are to have.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>

#include "absl/strings/str_cat.h"
#include "spectra/color/rgb_space.h"
#include "spectra/color/tristimulus.h"
#include "spectra/light/daylight.h"
#include "spectra/observer/observer.h"
#include "statistical/reference/lit_things.h"
#include "statistical/reference/picture.h"

namespace tessera::test {

inline constexpr const char* kSpectral = " color: COLOR_SPECTRAL ";

inline Picture picture_of(const std::string& scene, const std::string& integrator, std::uint32_t depth,
                          const std::string& settings, std::uint32_t seed = 0,
                          const TestBlobs& blobs = light_blobs()) {
  PictureRequest request;
  request.scene = scene;
  request.integrator = integrator;
  request.max_depth = depth;
  request.settings = settings;
  request.spp = samples_of_form(2048);
  request.seed = seed;
  request.blobs = blobs;
  return measure_picture(request);
}

/// Fails unless the whole picture has this colour, within its noise and a part of it.
inline void expect_color(const Picture& picture, const spectra::Triple& expected, double relative) {
  ASSERT_FALSE(picture.values.empty());
  for (int c = 0; c < 3; ++c) {
    const double error = picture.whole(c).error, tolerance = relative * std::abs(expected[c]);
    EXPECT_LT(error, 0.02 * std::abs(expected[c])) << "too noisy to tell anything, channel " << c;
    EXPECT_NEAR(picture.whole(c).mean, expected[c], 5 * error + tolerance) << "channel " << c;
  }
}

/// Linear Rec.709 of light that has this part of daylight at a wavelength.
inline spectra::Triple in_daylight(const std::function<double(double)>& part) {
  const spectra::Curve daylight = spectra::unit_d65();
  spectra::Curve light;
  for (int nm = 360; nm <= 830; ++nm) {
    light.nm.push_back(static_cast<float>(nm));
    light.values.push_back(static_cast<float>(part(nm) * daylight.at(nm)));
  }
  return spectra::times(spectra::rgb_from_xyz(spectra::kRec709),
                        spectra::tristimulus(light, spectra::cie1931()));
}

inline std::string message_of(const spectra::Curve& curve) {
  std::string text = "sampled { ";
  for (std::size_t i = 0; i < curve.nm.size(); ++i)
    absl::StrAppend(&text, "wavelengths_nm: ", curve.nm[i], " values: ", curve.values[i], " ");
  return text + "}";
}

}  // namespace tessera::test
