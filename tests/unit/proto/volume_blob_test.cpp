#include "wire/volume_blob.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <vector>

namespace tessera::wire {
namespace {

const std::vector<float> kSamples = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11};

std::string blob() { return encode_volume({1, 2, 3, 2, kSamples}); }

TEST(VolumeBlob, RoundTrips) {
  const std::string bytes = blob();
  const auto view = decode_volume(bytes);
  ASSERT_TRUE(view.ok()) << view.status();
  EXPECT_EQ(view->nx, 1u);
  EXPECT_EQ(view->ny, 2u);
  EXPECT_EQ(view->nz, 3u);
  EXPECT_EQ(view->channels, 2u);
  EXPECT_TRUE(std::equal(view->samples.begin(), view->samples.end(), kSamples.begin(), kSamples.end()));
}

TEST(VolumeBlob, RefusesEveryTruncation) {
  const std::string bytes = blob();
  for (std::size_t n = 0; n < bytes.size(); ++n)
    EXPECT_FALSE(decode_volume(std::string_view(bytes).substr(0, n)).ok()) << n;
  EXPECT_FALSE(decode_volume(bytes + std::string(4, '\0')).ok());
}

TEST(VolumeBlob, RefusesSizesThatCannotBe) {
  for (const std::uint32_t side : {0u, 65537u, 0xffffffffu}) {
    for (const std::size_t at : {8u, 12u, 16u, 20u}) {
      std::string bytes = blob();
      std::memcpy(bytes.data() + at, &side, sizeof(side));
      EXPECT_FALSE(decode_volume(bytes).ok()) << side << " at " << at;
    }
  }
}

TEST(VolumeBlob, RefusesSamplesThatAreNotFinite) {
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    std::vector<float> samples = kSamples;
    samples[7] = bad;
    EXPECT_FALSE(decode_volume(encode_volume({1, 2, 3, 2, samples})).ok());
  }
}

}  // namespace
}  // namespace tessera::wire
