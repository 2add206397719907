// Pyramids of images and filtered look-ups in them, against sums over texels.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <random>

#include "render/color/mip_pyramid.h"
#include "render/color/texture.h"

namespace tessera::render::TESSERA_ISA::mip_lookup_cases {
namespace {

TextureImage random_image(int width, int height, TexelFormat format) {
  std::mt19937 random(11);
  TextureImage image;
  image.width = width, image.height = height;
  image.format = format;
  for (int i = 0; i < 256; ++i)
    image.decode[i] = static_cast<float>(std::pow(i / 255.0, format == TexelFormat::kSrgb8 ? 2.2 : 1.0));
  for (int i = 0; i < width * height; ++i) {
    if (format != TexelFormat::kFloat) {
      image.texels8.push_back(static_cast<std::uint32_t>(random()));
      continue;
    }
    for (int c = 0; c < 4; ++c) image.texels32.push_back(static_cast<float>(random() % 1000) * 1e-3f);
  }
  return image;
}

/// Channel `c` of a texel of a level, linear.
double texel(const MipPyramid& pyramid, std::size_t level, int x, int y, int c) {
  const MipLevel& l = pyramid.levels[level];
  const auto at = static_cast<std::size_t>(l.first + y * l.stride + x);
  const auto channel = static_cast<std::size_t>(c);
  if (!pyramid.texels32.empty()) return pyramid.texels32[4 * at + channel];
  return (pyramid.texels16[2 * at + channel / 2] >> 16 * (c % 2) & 0xffff) / 65535.0;
}

double mean(const MipPyramid& pyramid, std::size_t level, int c) {
  const MipLevel& l = pyramid.levels[level];
  double sum = 0;
  for (int y = 0; y < l.height; ++y) {
    for (int x = 0; x < l.width; ++x) sum += texel(pyramid, level, x, y, c);
  }
  return sum / (l.width * l.height);
}

TextureTable table_of(TextureImage image, TexelFilter filter, WrapModes wrap = {}) {
  if (is_filtered(filter)) EXPECT_TRUE(make_pyramid(image, "test").ok());
  TextureNode node;
  node.kind = TextureKind::kImage;
  node.image = std::make_shared<const TextureImage>(std::move(image));
  node.filter = filter;
  node.wrap = wrap;
  TextureTable table;
  table.nodes = {node};
  return table;
}

TexturePoint footprint_at(Vec2 uv, float xu, float xv, float yu, float yv) {
  TexturePoint at = TexturePoint::at(uv);
  at.has_footprint = true;
  at.dpdx = at.dpdy = at.p;
  at.duvdx = {Float(xu), Float(xv)};
  at.duvdy = {Float(yu), Float(yv)};
  return at;
}

TEST(MipPyramid, EveryLevelHasTheMeanOfTheImage) {
  for (const TexelFormat format : {TexelFormat::kFloat, TexelFormat::kSrgb8, TexelFormat::kLinear8}) {
    for (const auto& [width, height] : {std::pair{16, 16}, {13, 7}, {1, 9}, {31, 1}, {6, 5}, {1, 1}}) {
      TextureImage image = random_image(width, height, format);
      ASSERT_TRUE(make_pyramid(image, "test").ok());
      EXPECT_TRUE(image.texels8.empty() && image.texels32.empty());
      const MipPyramid& pyramid = image.pyramid;
      EXPECT_EQ(pyramid.levels.back().width, 1);
      EXPECT_EQ(pyramid.levels.back().height, 1);
      for (std::size_t l = 1; l < pyramid.levels.size(); ++l) {
        EXPECT_EQ(pyramid.levels[l].width, std::max(pyramid.levels[l - 1].width / 2, 1));
        EXPECT_EQ(pyramid.levels[l].height, std::max(pyramid.levels[l - 1].height / 2, 1));
        // Each level rounds a texel by half of a 65535th at most.
        for (int c = 0; c < 4; ++c)
          EXPECT_NEAR(mean(pyramid, l, c), mean(pyramid, 0, c), 0.5 * static_cast<double>(l) / 65535 + 1e-6);
      }
    }
  }
}

TEST(MipPyramid, KeepsTexelsOfFullResolution) {
  for (const TexelFormat format : {TexelFormat::kFloat, TexelFormat::kSrgb8, TexelFormat::kLinear8}) {
    const TextureImage image = random_image(5, 3, format);
    TextureImage filtered = image;
    ASSERT_TRUE(make_pyramid(filtered, "test").ok());
    for (int y = 0; y < 3; ++y) {
      for (int x = 0; x < 5; ++x) {
        const auto i = static_cast<std::size_t>(5 * y + x);
        for (int c = 0; c < 4; ++c) {
          const double expected = format == TexelFormat::kFloat
                                      ? image.texels32[4 * i + static_cast<std::size_t>(c)]
                                  : c == 3 ? (image.texels8[i] >> 24) / 255.0
                                           : image.decode[image.texels8[i] >> 8 * c & 255];
          EXPECT_NEAR(texel(filtered.pyramid, 0, x, y, c), expected, 0.501 / 65535);
        }
      }
    }
  }
}

TEST(MipPyramid, RoundingDoesNotAddUp) {
  // Sums of four texels with every remainder. A bias of an eighth at each of seven levels would be 0.9.
  TextureImage image = random_image(1024, 1024, TexelFormat::kLinear8);
  ASSERT_TRUE(make_pyramid(image, "test").ok());
  // Errors of 0, 1/4, 1/2 and 1/4 with signs at random have a deviation of 0.31, those of a texel and of all
  // below it together 0.31 sqrt(1 + 1/4 + ...) < 0.36. The mean of 64 texels stays within five times an
  // eighth of that; a bias of 1/8 at each of seven levels would not.
  const std::size_t level = image.pyramid.levels.size() - 4;
  for (int c = 0; c < 4; ++c)
    EXPECT_NEAR(65535 * (mean(image.pyramid, level, c) - mean(image.pyramid, 0, c)), 0, 5 * 0.36 / 8);
}

TEST(MipPyramid, RefusesWhatItCannotAddress) {
  TextureImage image;
  image.width = 1, image.height = 1 << 28;
  const absl::Status status = make_pyramid(image, "tower.png");
  EXPECT_NE(status.message().find("tower.png"), std::string_view::npos) << status;
}

TEST(MipLookup, IsBilinearWhereTheFootprintIsWithinATexel) {
  std::mt19937 random(3);
  for (const TexelFormat format : {TexelFormat::kFloat, TexelFormat::kSrgb8}) {
    for (const WrapMode wrap : {WrapMode::kRepeat, WrapMode::kClamp, WrapMode::kBlack, WrapMode::kMirror}) {
      for (const auto& [width, height] : {std::pair{7, 5}, {1, 4}, {8, 1}}) {
        for (const int channel : {-1, 1, 3}) {
          const TextureImage image = random_image(width, height, format);
          const WrapModes modes{wrap, static_cast<WrapMode>((static_cast<int>(wrap) + channel + 1) % 4)};
          TextureTable plain = table_of(image, TexelFilter::kBilinear, modes);
          plain.nodes[0].channel = channel;
          for (const TexelFilter filter : {TexelFilter::kTrilinear, TexelFilter::kEwa}) {
            TextureTable filtered = table_of(image, filter, modes);
            filtered.nodes[0].channel = channel;
            for (int i = 0; i < 20; ++i) {
              alignas(64) float u[kWidth], v[kWidth];
              for (int l = 0; l < kWidth; ++l) {
                u[l] = static_cast<float>(random() % 8000) * 1e-3f - 4;
                v[l] = static_cast<float>(random() % 8000) * 1e-3f - 4;
              }
              const Vec2 uv{Float::load(u), Float::load(v)};
              const Spectrum expected = eval_texture(plain, 0, TexturePoint::at(uv), Mask::all());
              // Without a footprint, and with one of 0.4 texels.
              for (const TexturePoint& at :
                   {TexturePoint::at(uv), footprint_at(uv, 0.4f / 8, 0, 0, 0.4f / 8)}) {
                if (at.has_footprint && filter == TexelFilter::kEwa && width != height) continue;
                const Spectrum actual = eval_texture(filtered, 0, at, Mask::all());
                for (int l = 0; l < kWidth; ++l) {
                  for (int c = 0; c < 3; ++c) {
                    // The tolerance of texture_eval_test, and half of a 65535th.
                    ASSERT_NEAR(actual.c[c].lane(l), expected.c[c].lane(l), 6e-5)
                        << static_cast<int>(wrap) << " " << width << " " << u[l] << " " << v[l];
                  }
                }
              }
            }
          }
        }
      }
    }
  }
}

TEST(MipLookup, TakesTheLevelWhoseTexelsAreAsWideAsTheFootprint) {
  // Footprints of 2^k texels, at the middle of a texel of level k, halfway between levels, and of any size
  // beyond the image.
  const TextureImage image = random_image(16, 16, TexelFormat::kFloat);
  const TextureTable table = table_of(image, TexelFilter::kTrilinear);
  const MipPyramid& pyramid = table.nodes[0].image->pyramid;
  const auto value = [&](float u, float v, float half_width) {
    return eval_texture(table, 0, footprint_at({Float(u), Float(v)}, half_width, 0, 0, half_width),
                        Mask::all())
        .c[1]
        .lane(5);
  };
  for (std::size_t k = 0; k < 5; ++k) {
    const int n = 16 >> k;
    const float width = 1.0f / static_cast<float>(n);  // one texel, which the whole footprint has
    EXPECT_NEAR(value(0.5f * width, 1 - 0.5f * width, 0.5f * width), texel(pyramid, k, 0, 0, 1), 1e-5);
  }
  const double between = 0.5 * (texel(pyramid, 4, 0, 0, 1) + mean(pyramid, 4, 1));
  EXPECT_NEAR(value(0.3f, 0.2f, 8), between, 1e-5);
  EXPECT_NEAR(value(0.3f, 0.2f, std::numeric_limits<float>::max()), between, 1e-5);
}

TEST(MipLookup, TheShorterAxisDecides) {
  // Stripes of a texel along u: sharp while the footprint is thin across them, whichever way it is turned.
  TextureImage image;
  image.width = image.height = 64;
  for (int i = 0; i < 64 * 64; ++i) {
    for (int c = 0; c < 4; ++c) image.texels32.push_back(static_cast<float>(i % 2));
  }
  const TextureTable sharp = table_of(image, TexelFilter::kTrilinear),
                     smooth = table_of(image, TexelFilter::kEwa);
  const Vec2 on_a_stripe{Float(33.5f / 64), Float(0.5f)};
  const auto value = [&](const TextureTable& table, float xu, float xv, float yu, float yv) {
    return eval_texture_scalar(table, 0, footprint_at(on_a_stripe, xu, xv, yu, yv), Mask::all()).lane(9);
  };
  constexpr float kThin = 0.25f / 64, kLong = 2.0f / 64;
  EXPECT_NEAR(value(sharp, kLong, 0, 0, kThin), 1, 1e-5);
  EXPECT_NEAR(value(sharp, kThin, 0, 0, kLong), 1, 1e-5);
  // Along the stripes an ellipse sees one of them, across them all: eight probes half a texel apart, in pairs
  // that are mirror images about the middle of a stripe. Their weighted sum is the Gaussian's.
  EXPECT_NEAR(value(smooth, kThin, 0, 0, kLong), 1, 1e-5);
  double sum = 0, weights = 0;
  for (int i = 0; i < 8; ++i) {
    const double along = (2 * i + 1) / 8.0 - 1, weight = std::exp(-2 * along * along);
    const double from_stripe = std::abs(std::remainder(2 * along, 2.0));  // texels from the nearest one
    sum += weight * (1 - from_stripe), weights += weight;
  }
  EXPECT_NEAR(value(smooth, kLong, 0, 0, kThin), sum / weights, 1e-4);
  // Axes that are not at right angles span the ellipse: here the same one, with its axes at 45 degrees in the
  // circle that it is the image of.
  const float part = std::sqrt(0.5f);
  EXPECT_NEAR(value(smooth, part * kLong, part * kThin, -part * kLong, part * kThin), sum / weights, 1e-4);
  // No more than max_anisotropy: an ellipse a thousand times as long sees a wide blur, the mean.
  EXPECT_NEAR(value(smooth, 1000 * kThin, 0, 0, kThin), 0.5, 1e-3);
}

TEST(MipLookup, StaysFiniteForAnyFootprint) {
  const float inf = std::numeric_limits<float>::infinity(), nan = std::nanf("");
  for (const TexelFilter filter : {TexelFilter::kTrilinear, TexelFilter::kEwa}) {
    for (const WrapMode wrap : {WrapMode::kRepeat, WrapMode::kClamp, WrapMode::kBlack, WrapMode::kMirror}) {
      const TextureTable table =
          table_of(random_image(5, 3, TexelFormat::kSrgb8), filter, WrapModes{wrap, wrap});
      for (const float x : {nan, inf, -inf, 3e38f, 1e10f, -1e-45f, 0.3f, 0.0f}) {
        for (const float size : {0.0f, 1e-45f, 1e-20f, 1e8f, -1e8f}) {
          for (const float other : {0.0f, 1e8f, 0.01f}) {
            const TexturePoint at = footprint_at({Float(x), Float(0.5f)}, size, other, other, size);
            const Spectrum s = eval_texture(table, 0, at, Mask::first(7));
            for (int c = 0; c < 3; ++c) {
              EXPECT_TRUE(s.c[c].lane(0) >= 0 && s.c[c].lane(0) <= 1.0001f)
                  << x << " " << size << " " << other;
              EXPECT_EQ(s.c[c].lane(7), 0);
            }
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA::mip_lookup_cases
