// First roots of polynomial surfaces against arithmetic of 256 bits.
#include <cstdio>

#include "render/shape/implicit/polynomial_roots.h"
#include "stress/geometry/exact_polynomial.h"
#include "stress/geometry/implicit_table.h"

namespace tessera::render::TESSERA_ISA::implicit_roots {
namespace {

using test::ExactChord;
using test::Sturm256;
using test::wide256;

constexpr double kUnit = 0x1p-53;

/// The error of the polynomial along a ray in double precision, from wherever the ray comes: 12 (n + 2)
/// roundings of the sum of all terms' sizes, and four roundings of a point's coordinates
/// (polynomial_roots.h derives both); and as much again, for values within it count as zero.
double band_of(const ImplicitRecord& surface) {
  return 2 * kUnit * (12 * (surface.degree + 2) * surface.magnitude + 4 * surface.slope * surface.high[0]);
}

enum class Verdict { kMiss, kHit, kOpen, kWrong };

/// A value that is known up to `band` first leaves its sign between the first roots of the polynomial less
/// and plus the band: a hit has to lie there, and there has to be one if there is the latter.
Verdict judge(const ImplicitRecord& surface, const RayBatch& batch, int i) {
  const Point o = batch.origin(i), d = batch.direction(i);
  const bool hit = batch.shape[i] >= 0;
  const std::optional<ExactChord> chord = test::exact_chord(surface, o, d);
  if (!chord) return hit ? Verdict::kWrong : Verdict::kMiss;
  const double band = band_of(surface);
  const test::Wide256 start = test::value_of(chord->polynomial, wide256(-1));
  const int side = start < 0 ? -1 : 1;
  const auto shifted = [&](double by) {
    test::Series256 p = chord->polynomial;
    for (test::Wide256& c : p) c *= side;
    p[0] += by;
    return p;
  };
  const std::optional<double> earliest =
      abs(start) <= band ? std::optional(-1.0) : Sturm256(shifted(-band)).first_root();
  if (!earliest) return hit ? Verdict::kWrong : Verdict::kMiss;
  const std::optional<double> latest = Sturm256(shifted(band)).first_root();
  // The ray parameter is a float; the chord's ends are rounded.
  const double length = chord->end.get_d() - chord->begin.get_d();
  const double slack =
      4 * (0x1p-24 * batch.t[i] + 16 * kUnit * std::abs(chord->end.get_d())) / length + 0x1p-43;
  if (!hit) return !latest ? Verdict::kOpen : *latest > 1 - slack ? Verdict::kOpen : Verdict::kWrong;
  const double s = chord->s_of(batch.t[i]).get_d();
  if (s < *earliest - slack) return Verdict::kWrong;
  if (latest) return s <= *latest + slack ? Verdict::kHit : Verdict::kWrong;
  return Verdict::kOpen;
}

struct Tally {
  std::int64_t rays = 0, hits = 0, open = 0, wrong = 0;
};

/// Rays from `distance` sizes away: half of them through the ball, half close to tangents.
Tally compare(const NamedFunction& f, ImplicitRoots roots, double size, double distance, std::int64_t rays) {
  const Point at = unit({0.3, -0.7, 0.65}) * (distance * size);
  const ShapeTable table = implicit_table(f, roots, size, at);
  const TracedTable traced(table, false);
  Numbers random(31);
  RayBatch batch, touching;
  Tally tally;
  const auto count = [&](const RayBatch& traced_batch) {
    for (int i = 0; i < RayBatch::kSize && tally.rays < rays; ++i, ++tally.rays) {
      const Verdict verdict = judge(table.implicits[0], traced_batch, i);
      tally.hits += verdict == Verdict::kHit;
      tally.open += verdict == Verdict::kOpen;
      tally.wrong += verdict == Verdict::kWrong;
    }
  };
  while (tally.rays < rays) {
    for (int i = 0; i < RayBatch::kSize; ++i) {
      const Point o = at + random.direction() * (std::max(distance, 2 * f.radius) * size);
      batch.aim(i, o, at + random.direction() * (std::cbrt(random()) * f.radius * size));
    }
    traced.nearest(batch);
    count(batch);
    // Through points that lie 10^-1 to 10^-7 above where those rays have hit, along the surface.
    for (int first = 0; first < RayBatch::kSize; first += kWidth) {
      const Surface s = traced.surface(batch, first);
      for (int k = 0; k < kWidth; ++k) {
        const int i = first + k;
        if (batch.shape[i] < 0) {
          touching.set(i, batch.origin(i), random.direction());
          continue;
        }
        const Point p{s.p.x.lane(k), s.p.y.lane(k), s.p.z.lane(k)},
            n = unit({s.ng.x.lane(k), s.ng.y.lane(k), s.ng.z.lane(k)});
        const double off = std::pow(10.0, -1 - 6 * random()) * (random() < 0.5 ? 1 : -1) * size;
        const Point along = unit(cross(n, random.direction()));
        const Point target = p + n * off;
        touching.aim(i, target - along * (std::max(distance, 2 * f.radius) * size), target);
      }
    }
    traced.nearest(touching);
    count(touching);
  }
  return tally;
}

class ImplicitRootsTest : public testing::TestWithParam<NamedFunction> {};

TEST_P(ImplicitRootsTest, AreTheFirstOfExactArithmetic) {
  const NamedFunction& f = GetParam();
  const bool double_roots = std::string_view(f.name) == "double";
  // The tori have degree 12: ten times as slow.
  const double most = std::string_view(f.name) == "tori" ? 1e5 : 1e6;
  for (const ImplicitRoots roots : {ImplicitRoots::kSturm, ImplicitRoots::kInterval}) {
    for (const auto& [size, distance] :
         {std::pair(1.0, 0.0), std::pair(1e-6, 1e3), std::pair(1.0, 1e7), std::pair(1e6, 1e7)}) {
      const bool usual = distance == 0;
      const Tally tally =
          compare(f, roots, size, distance, usual ? stress_count(1e4, most) : stress_count(1e3, most / 20));
      SCOPED_TRACE(testing::Message()
                   << f.name << (roots == ImplicitRoots::kSturm ? ", sturm" : ", interval") << ", size "
                   << size << ", distance " << distance << ": " << tally.wrong << " wrong of " << tally.rays
                   << ", " << tally.hits << " hits, " << tally.open << " open");
      EXPECT_EQ(tally.wrong, 0);
      // Where a surface is touched and never crossed, every hit is a matter of rounding.
      if (double_roots) {
        EXPECT_GT(tally.open, tally.rays / 4);
      } else {
        EXPECT_GT(tally.hits, tally.rays / 10);
        EXPECT_LT(tally.open, tally.rays / 100);
      }
    }
  }
}

std::string name_of_function(const testing::TestParamInfo<NamedFunction>& info) { return info.param.name; }
INSTANTIATE_TEST_SUITE_P(All, ImplicitRootsTest, testing::ValuesIn(kPolynomials), name_of_function);

/// Newton's method from the ray's beginning finds a root, not the first: that is what it is there to show.
TEST(ImplicitNewton, MissesFirstRoots) {
  for (const NamedFunction& f : kPolynomials) {
    const Tally tally = compare(f, ImplicitRoots::kNewton, 1, 0, 2000);
    std::printf("newton, %s: %d wrong of %d\n", f.name, static_cast<int>(tally.wrong),
                static_cast<int>(tally.rays));
    if (std::string_view(f.name) == "sphere") {
      EXPECT_EQ(tally.wrong, 0);  // the first of two roots is found from outside, the other from there
    }
    if (std::string_view(f.name) == "barth") {
      EXPECT_GT(tally.wrong, 20);
    }
  }
}

/// Sturm's chains decide most rays by themselves, and find what intervals find: but where every root is
/// double, and at degree 12, where the bounds of the chain's errors outgrow its numbers.
TEST(ImplicitSturm, DecidesMostRays) {
  for (const NamedFunction& f : kPolynomials) {
    const ShapeTable table = implicit_table(f, ImplicitRoots::kSturm, 1, {});
    const ImplicitRecord& surface = table.implicits[0];
    Numbers random(34);
    std::int64_t chords = 0, open = 0, different = 0;
    for (int n = 0; n < 500; ++n) {
      RayBatch batch;
      for (int i = 0; i < kWidth; ++i)
        batch.aim(i, random.direction() * (2 * f.radius), random.direction() * (f.radius * random()));
      const Vec3 o{Float::load(batch.ox), Float::load(batch.oy), Float::load(batch.oz)},
          d{Float::load(batch.dx), Float::load(batch.dy), Float::load(batch.dz)};
      const ObjectChord chord = chord_within(surface, o, d, Double(0.0), Double(1e30), Mask::all());
      const ChordPolynomials along = expand_along(surface, chord);
      for (std::uint32_t bits = chord.meets.bits(); bits != 0; bits &= bits - 1) {
        const RayPolynomial p = along.lane(__builtin_ctz(bits));
        const std::optional<double> root = certain_root_by_sturm(p, false);
        ++chords;
        open += !root;
        // Both stop at 2^-50, where the slope is not much below what rounding takes off the values.
        if (root) different += std::abs(*root - first_root_by_intervals(p, false)) > 1e-6;
      }
    }
    std::printf("sturm, %s: %d of %d chords open, %d roots elsewhere\n", f.name, static_cast<int>(open),
                static_cast<int>(chords), static_cast<int>(different));
    EXPECT_EQ(different, 0) << f.name;
    EXPECT_GT(chords, 4000);
    if (std::string_view(f.name) != "double" && surface.degree < 12) {
      EXPECT_LT(open, chords / 20) << f.name;
    }
  }
}

/// A shadow ray needs the count alone: it has to agree with the search for the root.
TEST(ImplicitShadows, AreThoseOfFirstRoots) {
  for (const NamedFunction& f : kPolynomials) {
    for (const ImplicitRoots roots : {ImplicitRoots::kSturm, ImplicitRoots::kInterval}) {
      const ShapeTable table = implicit_table(f, roots, 1, {});
      const TracedTable traced(table, false);
      Numbers random(32);
      RayBatch batch;
      std::int64_t different = 0, hits = 0;
      for (int n = 0; n < 40; ++n) {
        for (int i = 0; i < RayBatch::kSize; ++i) {
          batch.aim(i, random.direction() * (2 * f.radius), random.direction() * (f.radius * random()));
          batch.distance[i] = static_cast<float>(20 * f.radius);
        }
        traced.nearest(batch);
        traced.shadow(batch);
        for (int i = 0; i < RayBatch::kSize; ++i) {
          hits += batch.shape[i] >= 0;
          different += (batch.shape[i] >= 0) != (batch.distance[i] < 0);
        }
      }
      EXPECT_EQ(different, 0) << f.name;
      EXPECT_GT(hits, 1000) << f.name;
    }
  }
}

/// Offset origins lie on the side that the ray leaves to, where f is beyond doubt: no ray meets its own
/// surface. By the sign of f there, in 256 bits.
TEST(ImplicitSurfaces, AreLeftWithoutSelfHits) {
  for (const NamedFunction& f : kPolynomials) {
    for (const double size : {1e-6, 1.0, 1e6}) {
      for (const double distance : {0.0, 10.0, 1000.0}) {
        const Point at = Point{0.6, -0.64, 0.48} * (distance * size);
        const ShapeTable table = implicit_table(f, ImplicitRoots::kSturm, size, at);
        const TracedTable traced(table, false);
        Numbers random(33);
        RayBatch batch;
        std::int64_t rays = 0, bad = 0;
        double widest = 0;
        const std::int64_t wanted = stress_count(2e3, 1e5);
        while (rays < wanted) {
          for (int i = 0; i < RayBatch::kSize; ++i) {
            const Point o = at + random.direction() * (2 * f.radius * size);
            batch.aim(i, o, at + random.direction() * (std::cbrt(random()) * f.radius * size));
          }
          traced.nearest(batch);
          for (int first = 0; first < RayBatch::kSize; first += kWidth) {
            const Surface s = traced.surface(batch, first);
            for (const float side : {1.0f, -1.0f}) {
              const Vec3 left = offset_origin(s, s.ng * side);
              for (int k = 0; k < kWidth; ++k) {
                if (batch.shape[first + k] < 0) continue;
                ++rays;
                widest = std::max(widest, double{s.error.lane(k)} / size);
                const Point p{left.x.lane(k), left.y.lane(k), left.z.lane(k)};
                const double value = test::exact_value(table.implicits[0], p).get_d();
                const bool squared = std::string_view(f.name) == "double";
                bad += squared ? !(value > 0) : !(value * side > 0);
              }
            }
          }
        }
        // Lines where sheets cross have no sides: next to them an offset ends beyond the other sheet.
        // Steiner's three are together about as long as the surface is large.
        const bool crossed = std::string_view(f.name) == "steiner";
        EXPECT_LE(static_cast<double>(bad), crossed ? static_cast<double>(rays) * (1e-3 + 2 * widest) : 0)
            << "of " << rays << ", " << f.name << ", size " << size << ", distance " << distance
            << ", widest offset " << widest;
      }
    }
  }
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA::implicit_roots
