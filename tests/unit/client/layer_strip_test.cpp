#include "image/layer_strip.h"

#include <gtest/gtest.h>

#include "image/heat_map.h"

namespace tessera::client {
namespace {

TEST(LayerStrip, PutsLayersSideBySide) {
  Image image;
  image.data = {3, 5, 5, 7};  // two by two pixels of a larger film
  image.display = {0, 0, 8, 8};
  float value = 0;
  for (const char* name : {"R", "G", "B", "a.R", "a.G", "a.B"}) {
    for (float& v : image.add(name).values) v = value++;
  }
  const auto strip = layer_strip(image, {"a", "rgba"});
  ASSERT_TRUE(strip.ok()) << strip.status();
  EXPECT_EQ(strip->data, (Window{0, 0, 4, 2}));
  EXPECT_EQ(strip->find("R")->values, (std::vector<float>{12, 13, 0, 1, 14, 15, 2, 3}));
  EXPECT_EQ(strip->find("B")->values, (std::vector<float>{20, 21, 8, 9, 22, 23, 10, 11}));
  EXPECT_EQ(layer_strip(image, {"b"}).status().message(), "the image has no layer 'b'");
}

TEST(LayerStrip, PaintsVisits) {
  Image image;
  image.data = image.display = {0, 0, 3, 1};
  EXPECT_FALSE(layer_strip(image, {"visits"}).ok());
  image.add("visits.nodes").values = {1, 2, 1000};
  image.add("visits.primitives").values = {0, 2, 24};
  const auto strip = layer_strip(image, {"visits"});
  ASSERT_TRUE(strip.ok()) << strip.status();
  // Black, a fifth of the way to white, white.
  EXPECT_EQ(strip->find("B")->values, (std::vector<float>{0, heat_colour(4)[2], 1}));
  EXPECT_NEAR(heat_colour(4)[2], 0.4, 1e-6);
}

}  // namespace
}  // namespace tessera::client
