#include "spectra/camera/cameras.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "spectra/color/tristimulus.h"
#include "spectra/light/illuminants.h"

namespace tessera::spectra {
namespace {

TEST(Cameras, SensitivitiesPeakAtOneInOrder) {
  const Observer camera = *find_camera("Nikon D5100");
  EXPECT_EQ(camera.rows.size(), 81u);
  EXPECT_EQ(camera.last_nm(), 780);
  double peaks[3];
  for (std::size_t c = 0; c < 3; ++c) {
    const auto peak = std::max_element(camera.rows.begin(), camera.rows.end(),
                                       [c](const Triple& a, const Triple& b) { return a[c] < b[c]; });
    EXPECT_EQ((*peak)[c], 1);
    peaks[c] = camera.first_nm + camera.step_nm * static_cast<double>(peak - camera.rows.begin());
  }
  EXPECT_EQ(peaks[0], 595);
  EXPECT_EQ(peaks[1], 530);
  EXPECT_EQ(peaks[2], 460);
  EXPECT_FALSE(find_camera("Brownie").has_value());
}

TEST(Cameras, SeeIncandescentLightAsRed) {
  for (const std::string& name : camera_names()) {
    const Observer camera = *find_camera(name);
    EXPECT_EQ(camera.first_nm, 380);
    EXPECT_EQ(camera.last_nm(), 780);
    const Triple a = tristimulus(*find_illuminant("A"), camera),
                 d65 = tristimulus(*find_illuminant("D65"), camera);
    EXPECT_GT(a[0] / a[1], 1.5 * d65[0] / d65[1]) << name;
    EXPECT_LT(a[2] / a[1], 0.6 * d65[2] / d65[1]) << name;
  }
}

}  // namespace
}  // namespace tessera::spectra
