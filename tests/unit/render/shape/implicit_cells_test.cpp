// Implicit surfaces that are searched cell by cell are met where they are without cells, one ray at a time as
// sixteen at once, and lines cross them as often as the signs at their ends say.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "expression/expression.h"
#include "render/shape/analytic_shape.h"
#include "render/shape/implicit/implicit_search.h"
#include "render/shape/implicit/mark_cells.h"

namespace tessera::render::TESSERA_ISA {
namespace {

constexpr const char* kFunctions[] = {
    "sin(6*x) + sin(6*y) + sin(6*z)",
    "exp(-8*((x-0.4)^2+y^2+z^2)) + exp(-8*((x+0.4)^2+y^2+z^2)) + exp(-8*(x^2+(y-0.4)^2+z^2)) - 0.5",
    "max(abs(x), abs(y), abs(z)) - 0.7",
    "sqrt(x^2 + y^2) - 0.5 + 0.2*noise(5*x, 5*y, 5*z)",
    "0.2/(x + 0.2) + y + z^2",
};

/// A surface within the unit ball.
ShapeTable table_of(const char* function, bool with_cells) {
  ImplicitRecord surface;
  for (int i = 0; i < 12; ++i) surface.render_from_object.m[i] = surface.object_from_render.m[i] = i % 5 == 0;
  surface.in_sphere = 1;
  const auto parsed = expression::parse(function);
  EXPECT_TRUE(parsed.ok()) << parsed.status();
  surface.program = *expression::compile(*parsed);
  if (with_cells) mark_cells(surface);
  ShapeTable table;
  table.implicits.push_back(std::move(surface));
  ShapeRecord shape;
  shape.kind = ShapeKind::kImplicit;
  shape.quadric = 0;
  table.shapes.push_back(shape);
  return table;
}

Float nearest(const ShapeTable& table, const ShapeRays& rays) {
  return analytic_shape(ShapeKind::kImplicit)->nearest(table, table.shapes[0], 0, rays);
}

/// Calls f(rays) for packets that look at the ball from all sides, `count` of them.
template <class F>
void for_each_packet(int count, F&& f) {
  std::uint32_t state = 12345;
  const auto number = [&state] {
    state = state * 1664525u + 1013904223u;
    return static_cast<float>(state >> 8) * 0x1p-24f;
  };
  for (int k = 0; k < count; ++k) {
    alignas(64) float o[3][kWidth], d[3][kWidth];
    for (int i = 0; i < kWidth; ++i) {
      const float z = 2 * number() - 1, phi = 6.2831853f * number(), r = std::sqrt(1 - z * z);
      const float from[3] = {3 * r * std::cos(phi), 3 * r * std::sin(phi), 3 * z};
      float length = 0;
      for (int a = 0; a < 3; ++a) {
        o[a][i] = from[a], d[a][i] = 1.6f * (number() - 0.5f) - from[a];
        length += d[a][i] * d[a][i];
      }
      for (int a = 0; a < 3; ++a) d[a][i] /= std::sqrt(length);
    }
    f(ShapeRays{{Float::load(o[0]), Float::load(o[1]), Float::load(o[2])},
                {Float::load(d[0]), Float::load(d[1]), Float::load(d[2])},
                Float(0.0f),
                Float(__builtin_inff()),
                Mask::all()});
  }
}

constexpr int kPackets = 250;

TEST(ImplicitCells, LeaveNoRootOut) {
  for (const char* function : kFunctions) {
    SCOPED_TRACE(function);
    const ShapeTable with = table_of(function, true), without = table_of(function, false);
    EXPECT_GT(with.implicits[0].cells, 8);
    EXPECT_EQ(without.implicits[0].cells, 0);
    int hits = 0;
    for_each_packet(kPackets, [&](const ShapeRays& rays) {
      const Float a = nearest(with, rays), b = nearest(without, rays);
      hits += __builtin_popcount((a > 0.0f).bits());
      // Roots are found to 2^-48 of the chord: floats of them differ by their last place at most.
      const Mask same = ((a < 0.0f) & (b < 0.0f)) | (abs(a - b) <= 0x1p-22f);
      EXPECT_EQ(same.bits(), 0xffffu);
    });
    EXPECT_GT(hits, kPackets);
  }
}

TEST(ImplicitCells, AreSearchedForOneRayAsForSixteen) {
  for (const char* function : kFunctions) {
    SCOPED_TRACE(function);
    for (const bool cells : {false, true}) {
      const ShapeTable table = table_of(function, cells);
      for_each_packet(kPackets / 10, [&](const ShapeRays& rays) {
        const Float all = nearest(table, rays);
        for (int i = 0; i < kWidth; ++i) {
          ShapeRays one = rays;
          one.active = Mask::from_bits(1u << i);
          const float t = nearest(table, one).lane(i), expected = all.lane(i);
          EXPECT_TRUE((t < 0 && expected < 0) || std::abs(t - expected) <= 0x1p-22f)
              << t << " and " << expected;
          const bool blocked =
              (analytic_shape(ShapeKind::kImplicit)->occluded(table, table.shapes[0], 0, one).bits() >> i &
               1) != 0;
          EXPECT_EQ(blocked, expected > 0);
        }
      });
    }
  }
}

/// A line has an even number of roots where f has one sign at both ends of its part in the ball, else an odd
/// one; the first in front is the one that a ray finds. (Not of the pole, over which the sign changes.)
TEST(ImplicitCells, AreCrossedAsOftenAsTheSignsSay) {
  for (int k = 0; k < 4; ++k) {
    SCOPED_TRACE(kFunctions[k]);
    const ShapeTable table = table_of(kFunctions[k], true);
    for_each_packet(kPackets / 10, [&](const ShapeRays& rays) {
      const Float t = nearest(table, rays);
      const ImplicitRecord& surface = table.implicits[0];
      for (int i = 0; i < kWidth; ++i) {
        const ExactRay ray{{rays.o.x.lane(i), rays.o.y.lane(i), rays.o.z.lane(i)},
                           {rays.d.x.lane(i), rays.d.y.lane(i), rays.d.z.lane(i)}};
        std::vector<double> found;
        analytic_shape(ShapeKind::kImplicit)->crossings(table, table.shapes[0], 0, ray, found);
        const ObjectChord chord = chord_of(surface, ray);
        if (none(chord.meets)) continue;
        alignas(64) double begin[kWidth], end[kWidth];
        value_at(surface, chord.at(chord.begin)).store(begin);
        value_at(surface, chord.at(chord.end)).store(end);
        EXPECT_EQ(found.size() % 2 != 0, (begin[0] < 0) != (end[0] < 0));
        if (found.empty()) {
          EXPECT_LT(t.lane(i), 0);
        } else {
          EXPECT_NEAR(*std::ranges::min_element(found), t.lane(i), 0x1p-21);
        }
      }
    });
  }
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
