// Free flights and transmittance against quadrature: what is scattered where, what comes through, what is
// emitted, for every component of the spectrum.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "statistical/medium/test_media.h"
#include "support/kernel/chi2.h"

namespace tessera::render::TESSERA_ISA {
namespace {

constexpr int kBins = 8;
constexpr int kFlights = 160000;

/// Five standard errors are exceeded once in 1.7 million by chance, and there are some thousands of values;
/// the rest is the rounding of float distances and the quadrature (48,000 midpoints of a function with kinks:
/// (h f')^2 of a part), and what is so rare that no sample may have met it.
void expect_mean(const Moments& m, double expected, const std::string& what) {
  EXPECT_NEAR(m.mean(), expected, 5 * m.error() + 2e-5 * expected + 1e-6) << what;
}

struct Ray {
  Point origin, direction;
  float distance;
};

/// All that one ray tells about medium 0 of `table`, for a path that carries `throughput`.
void check_ray(const MediumTable& table, const Ray& ray, const Rgb3& throughput) {
  const MediumRecord& medium = table.media[0];
  const Expected expected = integrate(table, medium, ray.origin, ray.direction, ray.distance, kBins);
  Spectrum beta;
  for (std::size_t c = 0; c < 3; ++c) beta.c[c] = Float(static_cast<float>(throughput[c]));
  const MediumRays rays{Int(0), wide(ray.origin), wide(ray.direction), Float(ray.distance)};
  Moments through[3], scattered[3], emitted[3], transmittance[3], in_bin[kBins][3];
  Random random(17);
  for (int i = 0; i < kFlights; i += kWidth) {
    NumberStream numbers(random.next_key());
    const Flight flight = sample_flight(table, rays, beta, random.next_2d(), numbers, Mask::all());
    NumberStream others(random.next_key());
    const Spectrum passed = sample_transmittance(table, rays, others, Mask::all());
    for (int l = 0; l < kWidth; ++l) {
      const bool scatters = flight.scattered.bits() >> l & 1;
      const double t = flight.t.lane(l);
      ASSERT_GE(t, 0);
      ASSERT_LE(t, ray.distance * (1 + 1e-6));
      const int bin = std::min(static_cast<int>(t / ray.distance * kBins), kBins - 1);
      for (std::size_t c = 0; c < 3; ++c) {
        const double weight = flight.weight.c[c].lane(l);
        ASSERT_TRUE(std::isfinite(weight) && weight >= 0);
        through[c].add(scatters ? 0 : weight);
        scattered[c].add(scatters ? weight : 0);
        for (int b = 0; b < kBins; ++b) in_bin[b][c].add(scatters && b == bin ? weight : 0);
        emitted[c].add(flight.emission.c[c].lane(l));
        transmittance[c].add(passed.c[c].lane(l));
      }
    }
  }
  for (std::size_t c = 0; c < 3; ++c) {
    const std::string channel = " " + std::to_string(c);
    expect_mean(transmittance[c], expected.transmittance[c], "transmittance" + channel);
    // A component that the path does not carry may be lost.
    if (throughput[c] == 0) continue;
    expect_mean(through[c], expected.transmittance[c], "through" + channel);
    expect_mean(scattered[c], expected.scattered[c], "scattered" + channel);
    expect_mean(emitted[c], expected.emitted[c], "emitted" + channel);
    for (int b = 0; b < kBins; ++b) {
      expect_mean(in_bin[b][c], expected.scattered_in_bin[static_cast<std::size_t>(b)][c],
                  "bin " + std::to_string(b) + channel);
    }
  }
}

void set(MediumValue& value, float r, float g, float b, std::int32_t grid = -1) {
  value.value[0] = r, value.value[1] = g, value.value[2] = b;
  value.grid = grid;
}

MediumTable homogeneous_table() {
  MediumTable table;
  MediumRecord medium;
  set(medium.sigma_t, 0.5f, 1.2f, 3.0f);
  set(medium.albedo, 0.9f, 0.5f, 0.2f);
  set(medium.emission, 2, 0, 0.3f);
  medium.emits = true;
  table.media = {medium};
  return table;
}

TEST(MediumFlight, HomogeneousMediaOfAnyColour) {
  MediumTable table = homogeneous_table();
  const Ray ray{{0, 0, 0}, {0, 0, 1}, 1.3f};
  check_ray(table, ray, {1, 1, 1});
  check_ray(table, ray, {1, 0.2, 0.05});
  check_ray(table, ray, {0, 0, 3});
  check_ray(table, ray, {1e-20, 2e-20, 0});
  // Extinction in one component only.
  set(table.media[0].sigma_t, 0, 0, 3);
  check_ray(table, ray, {1, 0.2, 0.05});
}

TEST(MediumFlight, GreyMediaHaveConstantWeights) {
  MediumTable table;
  MediumRecord medium;
  set(medium.sigma_t, 2, 2, 2);
  set(medium.albedo, 1, 1, 1);
  table.media = {medium};
  const float distance = 1.1f;
  const MediumRays rays{Int(0), wide({}), wide({1, 0, 0}), Float(distance)};
  constexpr std::size_t kCells = 50;
  std::vector<double> observed(kCells + 1), expected(kCells + 1);
  Random random(3);
  for (int i = 0; i < kFlights; i += kWidth) {
    NumberStream numbers(random.next_key());
    const Flight flight = sample_flight(table, rays, Spectrum(0.7f), random.next_2d(), numbers, Mask::all());
    for (int l = 0; l < kWidth; ++l) {
      // Quotients of equal numbers, up to the order of their sum.
      for (int c = 0; c < 3; ++c) ASSERT_NEAR(flight.weight.c[c].lane(l), 1, 1e-6);
      const bool scatters = flight.scattered.bits() >> l & 1;
      const auto cell = static_cast<std::size_t>(flight.t.lane(l) / distance * kCells);
      ++observed[scatters ? std::min(cell, kCells - 1) : kCells];
    }
  }
  for (std::size_t i = 0; i < kCells; ++i) {
    expected[i] =
        kFlights * (std::exp(-2.0 * distance * i / kCells) - std::exp(-2.0 * distance * (i + 1) / kCells));
  }
  expected[kCells] = kFlights * std::exp(-2.0 * distance);
  EXPECT_GT(test::chi_square_test(observed, expected).p_value, 1e-3);
}

TEST(MediumFlight, EndlessRays) {
  MediumTable table = homogeneous_table();
  const MediumRays rays{Int(0), wide({}), wide({1, 0, 0}), Float(1e18f)};
  NumberStream numbers(UInt(1u));
  const Spectrum none = sample_transmittance(table, rays, numbers, Mask::all());
  for (int c = 0; c < 3; ++c) EXPECT_LT(none.c[c].lane(0), 1e-40f);
  Random random(8);
  for (int i = 0; i < 1000; ++i) {
    const Flight flight = sample_flight(table, rays, Spectrum(1.0f), random.next_2d(), numbers, Mask::all());
    EXPECT_EQ(flight.scattered.bits(), 0xffffu);
    for (int c = 0; c < 3; ++c) EXPECT_TRUE(std::isfinite(flight.weight.c[c].lane(i % kWidth)));
  }
}

/// A turned and stretched box about (1, 2, 3), its edges about 2, 1 and 1.5 long: the map to the unit cube.
Affine box() {
  const Point x = unit({0.6, 0.7, -0.4}), y = unit({-0.7, 0.6, 0}),
              z{x.y * y.z - x.z * y.y, x.z * y.x - x.x * y.z, x.x * y.y - x.y * y.x};
  const Point centre{1, 2, 3}, rows[3] = {x * 0.5, y, z * (1 / 1.5)};
  Affine result;
  for (int a = 0; a < 3; ++a) {
    result.m[4 * a] = static_cast<float>(rows[a].x);
    result.m[4 * a + 1] = static_cast<float>(rows[a].y);
    result.m[4 * a + 2] = static_cast<float>(rows[a].z);
    result.m[4 * a + 3] = static_cast<float>(0.5 - dot(rows[a], centre));
  }
  return result;
}

/// The unit cube itself: axes and planes of the grid are those of space.
Affine unit_cube() {
  Affine result{};
  result.m[0] = result.m[5] = result.m[10] = 1;
  return result;
}

/// Extinction, albedo and emission each of a grid of their own.
MediumTable varied_table(const Affine& placement, std::int32_t channels) {
  MediumTable table;
  table.grids = {noise_grid(5, 4, 3, channels, placement, 1), noise_grid(2, 3, 2, 1, placement, 2),
                 noise_grid(3, 1, 2, 3, placement, 3)};
  for (float& x : table.grids[1].samples) x = std::min(x, 1.0f);
  MediumRecord medium;
  set(medium.sigma_t, 1, 2, 0.5f, 0);
  set(medium.albedo, 0.9f, 0.5f, 1, 1);
  set(medium.emission, 2, 1, 0.3f, 2);
  medium.emits = true;
  medium.homogeneous = false;
  medium.bounds_from_render = placement;
  table.media = {medium};
  build_majorants(table, table.media[0]);
  return table;
}

TEST(MediumFlight, GridsFromOutsideAndInside) {
  for (const std::int32_t channels : {1, 3}) {
    const MediumTable table = varied_table(box(), channels);
    // Through it, from within it, up to within it, and past it.
    for (const Ray& ray :
         {Ray{{-1, 0, 1}, unit({1.9, 2.1, 2}), 8}, Ray{{1.1, 2.1, 2.9}, unit({1, -0.3, 0.2}), 5},
          Ray{{4, 4.5, 1.5}, unit({-3, -2.5, 1.5}), 4}, Ray{{-1, 0, 1}, unit({-1, 1, 0}), 8}}) {
      SCOPED_TRACE(ray.origin.x);
      check_ray(table, ray, {1, 1, 1});
      check_ray(table, ray, {1, 0.1, 0.02});
    }
  }
}

TEST(MediumFlight, GridsAlongAxesAndPlanes) {
  const MediumTable table = varied_table(unit_cube(), 1);
  for (const Ray& ray :
       {Ray{{-1, 0.3, 0.6}, {1, 0, 0}, 3},      // along an axis
        Ray{{0.4, 0.5, 2}, {0, 0, -1}, 3},      // and on walls between cells
        Ray{{0.2, -1, 1.0 / 3}, {0, 1, 0}, 3},  // along edges of cells
        Ray{{0, 0, 0}, unit({1, 1, 1}), 2},     // corner to corner
        Ray{{1, 1, 1}, unit({-1, -1, -1}), 2}, Ray{{0, 0.5, 0.5}, {1, 0, 0}, 0.7f},  // starts on a face
        Ray{{0.6, 0.7, 0.2}, unit({1e-6, 1, 1e-6}), 3}}) {
    SCOPED_TRACE(ray.direction.x);
    check_ray(table, ray, {1, 1, 1});
  }
  // A ray within the face itself may count as inside or outside, but must come to an end.
  NumberStream numbers(UInt(5u));
  sample_transmittance(table, {Int(0), wide({0, -1, 0}), wide({0, 1, 0}), Float(3.0f)}, numbers, Mask::all());
}

TEST(MediumFlight, ExtinctionMayBeConstantWhereTheRestVaries) {
  MediumTable table = varied_table(box(), 1);
  set(table.media[0].sigma_t, 1, 2, 0.5f);
  build_majorants(table, table.media[0]);
  check_ray(table, {{-1, 0, 1}, unit({1.9, 2.1, 2}), 8}, {1, 1, 1});
}

TEST(MediumFlight, ScatteringMayBeGivenItself) {
  MediumTable table = varied_table(box(), 1);
  table.media[0].scattering_is_sigma_s = true;
  // In proportion to extinction, so that it is never more.
  set(table.media[0].albedo, 0.3f, 1.5f, 0.5f, 0);
  check_ray(table, {{-1, 0, 1}, unit({1.9, 2.1, 2}), 8}, {1, 0.5, 2});
}

TEST(MediumFlight, RaysFarFromASmallGridComeToAnEnd) {
  // A step from cell to cell is far below the precision of distances so far away.
  Affine tiny{};
  tiny.m[0] = tiny.m[5] = tiny.m[10] = 1e5f;
  MediumTable table;
  table.grids = {noise_grid(40, 40, 40, 1, tiny, 9)};
  MediumRecord medium;
  set(medium.sigma_t, 1, 1, 1, 0);
  medium.homogeneous = false;
  medium.bounds_from_render = tiny;
  table.media = {medium};
  build_majorants(table, table.media[0]);
  Random random(4);
  for (int i = 0; i < 10000; ++i) {
    alignas(64) float x[kWidth], y[kWidth], z[kWidth];
    (random.next() - 0.5f).store(x), (random.next() - 0.5f).store(y), (random.next() - 0.5f).store(z);
    const Vec3 d = normalize(Vec3{Float::load(x), Float::load(y), Float::load(z)});
    NumberStream numbers(random.next_key());
    sample_transmittance(table, {Int(0), d * -1e3f, d, Float(1e18f)}, numbers, Mask::all());
  }
}

TEST(MediumFlight, LanesOfDifferentMedia) {
  MediumTable table = homogeneous_table();
  MediumRecord other = table.media[0];
  set(other.sigma_t, 4, 4, 4);
  table.media.push_back(other);
  const Int media = Int::iota(0) & 1;
  Random random(6);
  const Vec2 u = random.next_2d();
  NumberStream numbers(UInt(1u));
  const auto fly = [&](Int medium, Mask active) {
    return sample_flight(table, {medium, wide({}), wide({1, 0, 0}), Float(0.8f)}, Spectrum(1.0f), u, numbers,
                         active);
  };
  const Flight mixed = fly(media, Mask::all()), first = fly(Int(0), Mask::all()),
               second = fly(Int(1), Mask::all());
  for (int l = 0; l < kWidth; ++l) {
    const Flight& own = l % 2 ? second : first;
    EXPECT_EQ(mixed.t.lane(l), own.t.lane(l));
    EXPECT_EQ(mixed.weight.c[1].lane(l), own.weight.c[1].lane(l));
    EXPECT_EQ(mixed.scattered.bits() >> l & 1, own.scattered.bits() >> l & 1);
  }
  // Nobody touches lanes that do not take part.
  const Flight half = fly(media, Mask::first(8));
  EXPECT_EQ(half.scattered.bits() >> 8, 0u);
  EXPECT_EQ(half.weight.c[0].lane(12), 1);
}

TEST(Majorants, BoundTheDensityAtEveryPoint) {
  for (const auto& size :
       {std::array{5, 4, 3}, std::array{70, 33, 1}, std::array{1, 1, 1}, std::array{32, 64, 2}}) {
    for (const std::int32_t channels : {1, 3}) {
      MediumTable table;
      table.grids = {noise_grid(size[0], size[1], size[2], channels, unit_cube(), 5)};
      MediumRecord medium;
      set(medium.sigma_t, 1, 2, 0.5f, 0);
      medium.homogeneous = false;
      medium.bounds_from_render = unit_cube();
      build_majorants(table, medium);
      ASSERT_EQ(medium.majorants.size(),
                static_cast<std::size_t>(medium.cells[0]) * medium.cells[1] * medium.cells[2]);
      std::mt19937 random(2);
      std::uniform_real_distribution<double> uniform(0, 1);
      double tightest = 0;
      for (int i = 0; i < 100000; ++i) {
        const Point p{uniform(random), uniform(random), uniform(random)};
        const Rgb3 sigma = density(table.grids[0], p);
        const auto cell = [&](int a, double x) {
          return std::min(static_cast<int>(x * medium.cells[a]), medium.cells[a] - 1);
        };
        const int index = (cell(2, p.z) * medium.cells[1] + cell(1, p.y)) * medium.cells[0] + cell(0, p.x);
        const double majorant = medium.majorants[static_cast<std::size_t>(index)];
        const double most = std::max({sigma[0], 2 * sigma[1], 0.5 * sigma[2]});
        ASSERT_LE(most, majorant * (1 + 1e-6));  // floats of the weights of interpolation
        if (majorant > 0) tightest = std::max(tightest, most / majorant);
      }
      EXPECT_GT(tightest, 0.5);  // a bound without use would pass the rest
    }
  }
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
