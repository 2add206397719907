// eval_texture against a scalar reading of the definitions.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "render/color/texture.h"

namespace tessera::render::TESSERA_ISA {
namespace {

struct Colour {
  double c[3] = {0, 0, 0};
};

/// Value of one texel, four channels, linear.
void read(const TextureImage& image, int x, int y, double (&rgba)[4]) {
  const auto index = static_cast<std::size_t>(y * image.width + x);
  for (std::size_t c = 0; c < 4; ++c) {
    if (image.format == TexelFormat::kFloat) {
      rgba[c] = image.texels32[index * 4 + c];
    } else {
      const std::uint32_t byte = image.texels8[index] >> (8 * c) & 255;
      rgba[c] = c == 3 ? byte / 255.0 : image.decode[byte];
    }
  }
}

/// Index of a texel of an infinite lattice of copies; -1 for black.
int wrapped(int i, int n, WrapMode mode) {
  const auto modulo = [](int a, int m) { return ((a % m) + m) % m; };
  switch (mode) {
    case WrapMode::kRepeat:
      return modulo(i, n);
    case WrapMode::kClamp:
      return std::min(std::max(i, 0), n - 1);
    case WrapMode::kBlack:
      return i < 0 || i >= n ? -1 : i;
    case WrapMode::kMirror: {
      const int m = modulo(i, 2 * n);
      return m < n ? m : 2 * n - 1 - m;
    }
  }
  return -1;
}

Colour texel(const TextureNode& node, int x, int y) {
  Colour result;
  x = wrapped(x, node.image->width, node.wrap.u);
  y = wrapped(y, node.image->height, node.wrap.v);
  if (x < 0 || y < 0) return result;
  double rgba[4];
  read(*node.image, x, y, rgba);
  for (int c = 0; c < 3; ++c) result.c[c] = rgba[node.channel < 0 ? c : node.channel];
  return result;
}

Colour image_reference(const TextureNode& node, double u, double v) {
  const double x = (node.scale_u * u + node.offset_u) * node.image->width;
  const double y = (1 - (node.scale_v * v + node.offset_v)) * node.image->height;
  Colour result;
  if (node.filter == TexelFilter::kNearest) {
    result = texel(node, static_cast<int>(std::floor(x)), static_cast<int>(std::floor(y)));
  } else {
    const int x0 = static_cast<int>(std::floor(x - 0.5)), y0 = static_cast<int>(std::floor(y - 0.5));
    const double tx = x - 0.5 - x0, ty = y - 0.5 - y0;
    for (int dy = 0; dy < 2; ++dy) {
      for (int dx = 0; dx < 2; ++dx) {
        const Colour corner = texel(node, x0 + dx, y0 + dy);
        for (int c = 0; c < 3; ++c) result.c[c] += corner.c[c] * (dx ? tx : 1 - tx) * (dy ? ty : 1 - ty);
      }
    }
  }
  for (double& c : result.c) {
    c *= node.scale;
    if (node.invert) c = std::max(0.0, 1 - c);
  }
  return result;
}

std::shared_ptr<const TextureImage> random_image(int width, int height, TexelFormat format) {
  std::mt19937 random(7);
  auto image = std::make_shared<TextureImage>();
  image->width = width;
  image->height = height;
  image->format = format;
  for (int i = 0; i < 256; ++i)
    image->decode[i] = static_cast<float>(std::pow(i / 255.0, format == TexelFormat::kSrgb8 ? 2.2 : 1.0));
  for (int i = 0; i < width * height; ++i) {
    if (format != TexelFormat::kFloat) {
      image->texels8.push_back(static_cast<std::uint32_t>(random()));
      continue;
    }
    for (int c = 0; c < 4; ++c) image->texels32.push_back(static_cast<float>(random() % 1000) * 1e-3f);
  }
  return image;
}

Vec2 random_uv(std::mt19937& random) {
  alignas(64) float u[kWidth], v[kWidth];
  for (int i = 0; i < kWidth; ++i) {
    u[i] = static_cast<float>(random() % 8000) * 1e-3f - 4;
    v[i] = static_cast<float>(random() % 8000) * 1e-3f - 4;
  }
  return {Float::load(u), Float::load(v)};
}

void expect_agreement(const TextureNode& node) {
  TextureTable table;
  table.nodes = {TextureNode{}, node};
  std::mt19937 random(1);
  for (int i = 0; i < 200; ++i) {
    const Vec2 uv = random_uv(random);
    const Mask active = Mask::from_bits(static_cast<std::uint32_t>(random() | 1) & 0xffff);
    const Spectrum actual = eval_texture(table, 1, TexturePoint::at(uv), active);
    for (int l = 0; l < kWidth; ++l) {
      const Colour expected =
          active.bits() >> l & 1 ? image_reference(node, uv.x.lane(l), uv.y.lane(l)) : Colour{};
      for (int c = 0; c < 3; ++c) {
        // Coordinates reach 4 * 16 texels in floats: 4e-6 of a texel at each step; neighbours differ by 1 at
        // most.
        ASSERT_NEAR(actual.c[c].lane(l), expected.c[c], 5e-5) << uv.x.lane(l) << " " << uv.y.lane(l);
      }
    }
  }
}

TextureNode image_node(std::shared_ptr<const TextureImage> image) {
  TextureNode node;
  node.kind = TextureKind::kImage;
  node.image = std::move(image);
  return node;
}

TEST(ImageTexture, AgreesWithTheDefinitionInEveryMode) {
  for (const TexelFormat format : {TexelFormat::kFloat, TexelFormat::kSrgb8, TexelFormat::kLinear8}) {
    for (const WrapMode wrap : {WrapMode::kRepeat, WrapMode::kClamp, WrapMode::kBlack, WrapMode::kMirror}) {
      for (const int channel : {-1, 0, 1, 2, 3}) {
        SCOPED_TRACE(testing::Message() << static_cast<int>(format) << static_cast<int>(wrap) << channel);
        TextureNode node = image_node(random_image(7, 5, format));
        node.wrap = {wrap, static_cast<WrapMode>((static_cast<int>(wrap) + channel + 1) % 4)};
        node.channel = channel;
        expect_agreement(node);
        node.scale = 1.5f;
        node.invert = true;
        node.scale_u = 0.7f;
        node.scale_v = -1.3f;
        node.offset_u = 0.21f;
        node.offset_v = 0.43f;
        expect_agreement(node);
      }
    }
  }
}

TEST(ImageTexture, NearestReadsTheTexelUnderThePoint) {
  // Coordinates in the middle of texels, where rounding decides nothing.
  TextureNode node = image_node(random_image(8, 4, TexelFormat::kFloat));
  node.filter = TexelFilter::kNearest;
  for (const WrapMode wrap : {WrapMode::kRepeat, WrapMode::kClamp, WrapMode::kBlack, WrapMode::kMirror}) {
    node.wrap = {wrap, wrap};
    TextureTable table;
    table.nodes = {node};
    for (int y = -12; y < 12; ++y) {
      const Vec2 uv = {(to_float(Int::iota(-8)) + 0.5f) * (1.0f / 8),
                       Float((static_cast<float>(y) + 0.5f) / 4)};
      const Spectrum actual = eval_texture(table, 0, TexturePoint::at(uv), Mask::all());
      for (int l = 0; l < kWidth; ++l) {
        EXPECT_FLOAT_EQ(actual.c[0].lane(l),
                        static_cast<float>(image_reference(node, uv.x.lane(l), uv.y.lane(l)).c[0]));
      }
    }
  }
}

TEST(ImageTexture, HasItsOriginAtTheLowerLeft) {
  auto image = std::make_shared<TextureImage>();
  image->width = image->height = 2;
  for (int i = 0; i < 16; ++i) image->texels32.push_back(static_cast<float>(1 + i / 4));
  TextureTable table;
  table.nodes = {image_node(image)};
  const auto at = [&](float u, float v) {
    return eval_texture_scalar(table, 0, TexturePoint::at({Float(u), Float(v)}), Mask::all()).lane(0);
  };
  EXPECT_EQ(at(0.25f, 0.25f), 3);  // the file's last row, first texel
  EXPECT_EQ(at(0.75f, 0.25f), 4);
  EXPECT_EQ(at(0.25f, 0.75f), 1);
  EXPECT_EQ(at(0.75f, 0.75f), 2);
  EXPECT_EQ(at(0.5f, 0.5f), 2.5f);
}

TEST(ImageTexture, StaysFiniteForAnyCoordinate) {
  const float inf = std::numeric_limits<float>::infinity(), nan = std::nanf("");
  TextureTable table;
  for (const WrapMode wrap : {WrapMode::kRepeat, WrapMode::kClamp, WrapMode::kBlack, WrapMode::kMirror}) {
    for (const bool nearest : {false, true}) {
      table.nodes.push_back(image_node(random_image(5, 3, TexelFormat::kFloat)));
      table.nodes.back().wrap = {wrap, wrap};
      table.nodes.back().filter = nearest ? TexelFilter::kNearest : TexelFilter::kBilinear;
    }
  }
  TextureNode checker;
  checker.kind = TextureKind::kCheckerboard;
  checker.inputs[0] = 0;
  checker.inputs[1] = 1;
  table.nodes.push_back(checker);
  for (const float x : {nan, inf, -inf, 3e38f, -3e38f, 1e10f, 16777217.0f, -1e-45f, 0x1.fffffep-1f}) {
    for (const float y : {0.5f, nan, -inf, 1e20f}) {
      for (int node = 0; node < static_cast<int>(table.nodes.size()); ++node) {
        const Spectrum s = eval_texture(table, node, TexturePoint::at({Float(x), Float(y)}), Mask::all());
        for (int c = 0; c < 3; ++c) {
          EXPECT_TRUE(s.c[c].lane(0) >= 0 && s.c[c].lane(0) <= 1) << x << " " << y << " node " << node;
        }
      }
    }
  }
}

TextureNode constant(float r, float g, float b) {
  TextureNode node;
  node.value[0] = r;
  node.value[1] = g;
  node.value[2] = b;
  return node;
}

TEST(TextureTree, CheckerboardAlternates) {
  TextureNode node;
  node.kind = TextureKind::kCheckerboard;
  node.inputs[0] = 0;
  node.inputs[1] = 1;
  node.scale_u = 2;
  node.offset_v = -0.5f;
  TextureTable table;
  table.nodes = {constant(1, 1, 1), constant(0, 0, 0), node};
  std::mt19937 random(1);
  for (int i = 0; i < 50; ++i) {
    const Vec2 uv = random_uv(random);
    const Spectrum s = eval_texture(table, 2, TexturePoint::at(uv), Mask::first(12));
    for (int l = 0; l < kWidth; ++l) {
      const auto cell = static_cast<int>(std::floor(2 * uv.x.lane(l)) + std::floor(uv.y.lane(l) - 0.5f));
      EXPECT_EQ(s.c[1].lane(l), l < 12 && cell % 2 == 0 ? 1 : 0);
    }
  }
}

TEST(TextureTree, ScalesAndMixes) {
  TextureNode scale, mix;
  scale.kind = TextureKind::kScale;
  scale.inputs[0] = 0;
  scale.inputs[1] = 1;
  mix.kind = TextureKind::kMix;
  mix.inputs[0] = 0;
  mix.inputs[1] = 3;
  mix.inputs[2] = 2;
  TextureTable table;
  table.nodes = {constant(1, 2, 3), constant(0.5f, 0.25f, 2), constant(0.1f, 0.2f, 0.6f), scale, mix};
  const Vec2 uv = {Float(0.5f), Float(0.5f)};
  const Spectrum product = eval_texture(table, 3, TexturePoint::at(uv), Mask::all()),
                 mixed = eval_texture(table, 4, TexturePoint::at(uv), Mask::all());
  const float expected[3] = {0.5f, 0.5f, 6};
  for (int c = 0; c < 3; ++c) {
    EXPECT_FLOAT_EQ(product.c[c].lane(3), expected[c]);
    // The amount is the mean of its colour, 0.3.
    EXPECT_FLOAT_EQ(mixed.c[c].lane(3), 0.7f * static_cast<float>(c + 1) + 0.3f * expected[c]);
  }
  EXPECT_FLOAT_EQ(eval_texture_scalar(table, 3, TexturePoint::at(uv), Mask::all()).lane(0), 7.0f / 3);
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
