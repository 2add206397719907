// Noise and what is made of it, against values computed apart from it in double precision.
#include <gtest/gtest.h>

#include <limits>

#include "render/color/noise.h"
#include "render/color/procedural.h"
#include "render/color/texture.h"

namespace tessera::render::TESSERA_ISA {
namespace {

float lane(Float x, int i) {
  alignas(64) float lanes[kWidth];
  x.store(lanes);
  return lanes[i];
}

Vec3 at(float x, float y, float z) { return {Float(x), Float(y), Float(z)}; }

// Ten roundings of numbers up to 1.
constexpr float kTolerance = 2e-6f;

TEST(Noise, HasPerlinsValues) {
  EXPECT_EQ(lane(noise(at(3, -7, 12)), 0), 0);
  EXPECT_NEAR(lane(noise(at(0.5f, 0.5f, 0.5f)), 0), -0.125f, kTolerance);
  EXPECT_NEAR(lane(noise(at(1.25f, -2.5f, 3.75f)), 5), 0.00803661346f, kTolerance);
  // The coordinates themselves are rounded by up to 1.5e-5, and slopes stay below 2 each way.
  EXPECT_NEAR(lane(noise(at(255.3f, 256.7f, -0.2f)), 9), 0.327294054f, 1e-4f);
  EXPECT_NEAR(lane(noise(at(-12.6f, 40.1f, 7.9f)), 15), 0.292405488f, 1e-5f);
}

TEST(Noise, SumsOctaves) {
  // Points up to 3.75 * 1.99^3 = 30, rounded by up to 1e-6, and slopes below 2.
  EXPECT_NEAR(lane(fractal_noise(at(1.25f, -2.5f, 3.75f), 0.5f, 4), 0), 0.155803527f, 2e-5f);
  EXPECT_NEAR(lane(turbulence(at(1.25f, -2.5f, 3.75f), 0.6f, 3), 0), 0.226050026f, 2e-5f);
}

TEST(Noise, SurvivesAnyPoint) {
  const float huge = 3e38f;
  EXPECT_EQ(lane(noise(at(huge, -huge, 1)), 0), 0);
  EXPECT_EQ(lane(noise(at(std::numeric_limits<float>::quiet_NaN(), 0, 0)), 0), 0);
}

TEST(Procedural, DotsLieInTheCellsOfPbrt) {
  int dots = 0;
  constexpr int kCells = 40;
  for (int i = 0; i < kCells; ++i) {
    for (int j = 0; j < kCells; ++j) {
      // A dot of radius 0.35 that is shifted by at most 0.15 covers the centre of its cell.
      const std::uint32_t bits =
          inside_dot({Float(static_cast<float>(i)), Float(static_cast<float>(j))}).bits();
      dots += bits & 1;
      const Vec2 corner{Float(static_cast<float>(i) + 0.5f), Float(static_cast<float>(j) + 0.5f)};
      EXPECT_EQ(inside_dot(corner).bits(), 0u);  // 0.7 from the nearest centre that a dot can have
    }
  }
  EXPECT_EQ(dots, 596);  // counted with another program: noise is exactly 0 in many cells
}

TEST(Procedural, MappingsLookAtThePoint) {
  TextureTable table;
  table.nodes.resize(3);
  table.nodes[0].value[0] = 1;
  table.nodes[1].value[1] = 1;
  TextureNode& board = table.nodes[2];
  board.kind = TextureKind::kCheckerboard;
  board.inputs[0] = 0, board.inputs[1] = 1;
  board.plain_uv = false;
  TexturePoint point = TexturePoint::at({Float(0.0f), Float(0.0f)});
  const auto is_even = [&] { return lane(eval_texture(table, 2, point, Mask::all()).c[0], 0) == 1; };

  board.source = UvSource::kPlanar;
  point.p = at(1.5f, 0.5f, 9);
  EXPECT_FALSE(is_even());
  board.source = UvSource::kSpherical;
  board.scale_u = 2, board.scale_v = 4;  // u: hemispheres about z; v: quarters of a turn from +x
  point.p = at(1, 1, 5);
  EXPECT_TRUE(is_even());
  point.p = at(-1, 1, 5);
  EXPECT_FALSE(is_even());
  point.p = at(-1, 1, -5);
  EXPECT_TRUE(is_even());
  board.source = UvSource::kCylindrical;
  board.scale_u = 4, board.scale_v = 1;
  point.p = at(1, -1, 0.5f);  // the last quarter
  EXPECT_FALSE(is_even());
  board.solid = true;
  point.p = at(-0.5f, 0.5f, 0.5f);
  EXPECT_FALSE(is_even());
  point.p = at(-0.5f, -0.5f, 0.5f);
  EXPECT_TRUE(is_even());
}

TEST(Procedural, DirectionMixFollowsTheNormal) {
  TextureTable table;
  table.nodes.resize(3);
  for (float& c : table.nodes[0].value) c = 1;
  table.nodes[2].kind = TextureKind::kDirectionMix;
  table.nodes[2].inputs[0] = 0, table.nodes[2].inputs[1] = 1;
  TexturePoint point = TexturePoint::at({Float(0.0f), Float(0.0f)});
  point.n = at(0.8f, -0.6f, 0);
  EXPECT_NEAR(lane(eval_texture_scalar(table, 2, point, Mask::all()), 0), 0.6f, kTolerance);
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
