#include "optics/film_gauge.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace tessera::optics {
namespace {

using testing::HasSubstr;

TEST(FilmGauge, IsFoundByNameWhateverItsCapitals) {
  ASSERT_NE(find_film_gauge("Super35"), nullptr);
  EXPECT_EQ(find_film_gauge("Super35")->frame.width, 24.89);
  EXPECT_EQ(find_film_gauge("supr35"), nullptr);
  EXPECT_EQ(find_film_gauge(""), nullptr);
  EXPECT_THAT(unknown_film_gauge("supr35"), HasSubstr("did you mean 'super35'?"));
  for (const FilmGauge& gauge : film_gauges()) {
    EXPECT_GE(gauge.frame.width, gauge.frame.height) << gauge.name;
    EXPECT_FALSE(gauge.source.empty()) << gauge.name;
  }
}

TEST(FilmGauge, PicturesAreAsLargeAsTheFrameLets) {
  const FilmSize frame{36, 24};
  const FilmSize wide = picture_on(frame, 16.0 / 9), same = picture_on(frame, 1.5),
                 upright = picture_on(frame, 2.0 / 3), square = picture_on(frame, 1);
  EXPECT_DOUBLE_EQ(wide.width, 36);
  EXPECT_DOUBLE_EQ(wide.height, 20.25);
  EXPECT_DOUBLE_EQ(same.width, 36);
  EXPECT_DOUBLE_EQ(same.height, 24);
  EXPECT_DOUBLE_EQ(upright.width, 24);
  EXPECT_DOUBLE_EQ(upright.height, 36);
  EXPECT_DOUBLE_EQ(square.width, 24);
  EXPECT_DOUBLE_EQ(square.height, 24);
}

}  // namespace
}  // namespace tessera::optics
