#include "image/flip.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace tessera::client {
namespace {

Image constant(float r, float g, float b, int width = 64, int height = 48) {
  Image image;
  image.data = image.display = {0, 0, width, height};
  const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  image.add("R").values.assign(pixels, r);
  image.add("G").values.assign(pixels, g);
  image.add("B").values.assign(pixels, b);
  return image;
}

TEST(Flip, OfEqualImagesIsZero) {
  EXPECT_NEAR(*flip_error(constant(0.2f, 0.5f, 0.7f), constant(0.2f, 0.5f, 0.7f)), 0, 1e-6);
}

TEST(Flip, OfTheTwoColoursFarthestApartIsOne) {
  // The scale's end is defined as the difference between the green and the blue primary; constant images have
  // no features.
  EXPECT_NEAR(*flip_error(constant(0, 1, 0), constant(0, 0, 1)), 1, 1e-3);
}

TEST(Flip, OfGreysFollowsTheirLightness) {
  // Lightness of linear 0.18 is 49.496, of 0.2 51.837: HyAB 2.341, to the power 0.7: 1.814. The largest
  // difference is that of the primaries: green is L 87.735, a -86.183, b 83.179, blue L 32.297, a 79.188, b
  // -107.86, with Hunt's factor L / 100: 55.438 + hypot(-75.613 - 25.575, 72.977 + 34.836) = 203.30, to the
  // power 0.7: 41.27. Below 0.4 of it, the error is 0.95 / 0.4 of the ratio: 0.1044.
  EXPECT_NEAR(*flip_error(constant(0.18f, 0.18f, 0.18f), constant(0.2f, 0.2f, 0.2f)), 0.1044, 5e-4);
}

TEST(Flip, SeesWhatTheScreenShows) {
  const float infinity = std::numeric_limits<float>::infinity();
  EXPECT_NEAR(*flip_error(constant(1, 1, 1), constant(50, infinity, 2)), 0, 1e-6);
  EXPECT_NEAR(*flip_error(constant(0, 0, 0), constant(std::nanf(""), -3, 0)), 0, 1e-6);
}

TEST(Flip, IsWorseForAnEdgeThanForTheSameDifferenceSpreadOut) {
  Image edge = constant(0.5f, 0.5f, 0.5f), flat = edge;
  for (Channel& channel : edge.channels) {
    for (std::size_t i = 0; i < channel.values.size(); ++i) channel.values[i] += i % 64 < 32 ? 0.05f : -0.05f;
  }
  for (Channel& channel : flat.channels) {
    for (float& value : channel.values) value += 0.05f;
  }
  const Image reference = constant(0.5f, 0.5f, 0.5f);
  EXPECT_GT(*flip_error(reference, edge), 1.05 * *flip_error(reference, flat));
}

TEST(Flip, NeedsEqualSizes) { EXPECT_FALSE(flip_error(constant(0, 0, 0), constant(0, 0, 0, 32, 32)).ok()); }

}  // namespace
}  // namespace tessera::client
