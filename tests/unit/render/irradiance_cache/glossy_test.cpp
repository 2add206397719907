// Harmonics over the hemisphere, radiance and its gradients in them, and records that are looked up.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "render/textbook/irradiance_cache/cache.h"
#include "render/textbook/irradiance_cache/glossy_cache.h"
#include "render/textbook/irradiance_cache/radiance_hemisphere.h"

namespace tessera::render::TESSERA_ISA::glossy_records {  // apart from tests that are compiled with these
namespace {

constexpr int kSomeBands = 8;

Vec3 everywhere(float x, float y, float z) { return {Float(x), Float(y), Float(z)}; }

std::vector<float> harmonics_at(const Harmonics& harmonics, double x, double y, double z) {
  Float values[Harmonics::kMost];
  harmonics.evaluate(everywhere(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)), values);
  std::vector<float> result;
  for (int i = 0; i < harmonics.count(); ++i) result.push_back(values[i].lane(0));
  return result;
}

TEST(Harmonics, AreOrthonormalOverTheHemisphere) {
  const Harmonics harmonics(Harmonics::kMostBands);
  const auto n = static_cast<std::size_t>(harmonics.count());
  ASSERT_EQ(n, 78u);
  // Midpoints in z and azimuth: products have polynomials in z of degree 22 and waves of up to 22 in azimuth.
  // The former have errors of below h^2 / 24 times the second derivative's integral, which is below that of
  // the slopes at the ends, 22^2 times their largest value, some 10: 2e-3 for 1000 steps.
  constexpr int kHeights = 1000, kTurns = 48;
  std::vector<double> products(n * n, 0);
  for (int i = 0; i < kHeights; ++i) {
    for (int j = 0; j < kTurns; ++j) {
      const double z = (i + 0.5) / kHeights, angle = 2 * std::numbers::pi * (j + 0.5) / kTurns;
      const double sine = std::sqrt(1 - z * z);
      const std::vector<float> h = harmonics_at(harmonics, sine * std::cos(angle), sine * std::sin(angle), z);
      for (std::size_t a = 0; a < n; ++a) {
        for (std::size_t b = 0; b <= a; ++b)
          products[a * n + b] += double{h[a]} * double{h[b]} * 2 * std::numbers::pi / (kHeights * kTurns);
      }
    }
  }
  for (std::size_t a = 0; a < n; ++a) {
    for (std::size_t b = 0; b <= a; ++b)
      EXPECT_NEAR(products[a * n + b], a == b ? 1 : 0, 2e-3) << a << " " << b;
  }
}

TEST(Harmonics, BelowTheHorizonIsTheMirrorImage) {
  const Harmonics harmonics(kSomeBands);
  const std::vector<float> above = harmonics_at(harmonics, 0.48, 0.6, 0.64),
                           below = harmonics_at(harmonics, 0.48, 0.6, -0.64);
  for (std::size_t i = 0; i < above.size(); ++i) EXPECT_FLOAT_EQ(above[i], below[i]) << i;
}

// ---- light in harmonics

struct Seen {
  double radiance, distance;
};
/// The light that is seen from (x, 0, 0) along a unit direction.
using World = std::function<Seen(double x, const double (&d)[3])>;

/// Rays through the middle of every cell.
RadianceHemisphere::Estimate look_around(const World& world, double x, int samples, int bands) {
  RadianceHemisphere hemisphere(samples, bands);
  for (int first = 0; first < hemisphere.cells(); first += kWidth) {
    const Vec3 d = hemisphere.direction(Int::iota(first), {Float(0.5f), Float(0.5f)});
    alignas(64) float radiance[kWidth], distance[kWidth];
    for (int i = 0; i < kWidth; ++i) {
      const Seen seen =
          world(x, {double{d.x.lane(i)}, double{d.y.lane(i)}, double{std::max(d.z.lane(i), 1e-6f)}});
      radiance[i] = static_cast<float>(seen.radiance), distance[i] = static_cast<float>(seen.distance);
    }
    const Float light = Float::load(radiance);
    hemisphere.set(first, d, {light, 2.0f * light, Float(0.0f)}, Float::load(distance));
  }
  return hemisphere.estimate();
}

TEST(RadianceHemisphere, EvenLightIsInTheFirstBand) {
  const auto e = look_around([](double, const double(&)[3]) { return Seen{3, 5}; }, 0, 4096, kSomeBands);
  ASSERT_EQ(e.numbers.size(), 36u * GlossyRecords::kOfCoefficient);
  // The first function is 1 / sqrt(2 pi) everywhere. Others are integrated by points in the middle of cells,
  // 1/31 high: (1/31)^2 / 24 of a second derivative of below 8^2 times their size.
  const double first = 3 * std::sqrt(2 * std::numbers::pi);
  EXPECT_NEAR(e.numbers[0], first, 1e-4 * first);
  EXPECT_NEAR(e.numbers[1], 2 * first, 2e-4 * first);
  for (std::size_t i = 1; i < 36; ++i)
    EXPECT_NEAR(e.numbers[i * GlossyRecords::kOfCoefficient], 0, 0.02 * first) << i;
  for (std::size_t i = 0; i < e.numbers.size(); ++i) {
    if (i % GlossyRecords::kOfCoefficient >= kBands) {
      EXPECT_NEAR(e.numbers[i], 0, 1e-3) << i;
    }
  }
  EXPECT_NEAR(e.mean_distance, 5, 1e-4);
  EXPECT_NEAR(e.nearest, 5, 1e-6);
}

/// A disk lamp of radius 1 and radiance 1 facing down, 1 above the plane, and its axis at 0; black around.
Seen below_disk(double x, const double (&d)[3]) {
  const double t = 1 / d[2];
  return {std::hypot(x + d[0] * t, d[1] * t) < 1 ? 1.0 : 0.0, t};
}

TEST(RadianceHemisphere, CoefficientsChangeAsTheirGradientsSay) {
  // There are 90,000 cells, 1/147 of z high: borders pass through cells in steps, by which each coefficient
  // errs, and so do gradients: by about a cell of each of two borders, 1.4 %, of their largest, and 3 are
  // allowed. The differences are of places 0.1 away on both sides, whose cells' errors (0.7 % of some 2.5)
  // over 0.2 are the same again.
  constexpr int kSamples = 90'000, kFew = 4;
  for (const double x : {0.0, 0.7, 1.6}) {
    const auto here = look_around(below_disk, x, kSamples, kFew);
    const auto before = look_around(below_disk, x - 0.1, kSamples, kFew),
               after = look_around(below_disk, x + 0.1, kSamples, kFew);
    double largest = 0;
    std::vector<double> slopes;
    for (std::size_t i = 0; i < here.numbers.size(); i += GlossyRecords::kOfCoefficient) {
      slopes.push_back((double{after.numbers[i]} - double{before.numbers[i]}) / 0.2);
      largest = std::max(largest, std::abs(slopes.back()));
    }
    ASSERT_GT(largest, 0.3);
    for (std::size_t k = 0; k < slopes.size(); ++k) {
      const float* const numbers = here.numbers.data() + k * GlossyRecords::kOfCoefficient;
      EXPECT_NEAR(numbers[kBands], slopes[k], 0.06 * largest) << x << ", function " << k;
      EXPECT_NEAR(numbers[kBands + 1], 2 * slopes[k], 0.12 * largest);
      EXPECT_EQ(numbers[kBands + 2], 0);
    }
  }
}

// ---- records

GlossyRecords records_of(int bands, const std::vector<RecordSite>& sites, std::uint32_t seed) {
  GlossyRecords records;
  records.bands = bands;
  records.sites = sites;
  records.numbers.resize(sites.size() * records.stride());
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> value(-1, 1);
  for (float& number : records.numbers) number = value(random);
  return records;
}

RecordSite site_at(float x, float y, float z) {
  return {.p = {x, y, z}, .n = {0, 0, 1}, .radius = 1, .pixel = 0.01f};
}

std::vector<RecordSite> scattered_sites(int n) {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> place(-1, 1), radius(0.3f, 2);
  std::vector<RecordSite> sites;
  for (int i = 0; i < n; ++i) {
    RecordSite site = site_at(place(random), place(random), 0);
    site.radius = radius(random);
    const float turn = 0.2f * place(random);
    site.n[0] = std::sin(turn), site.n[2] = std::cos(turn);
    sites.push_back(site);
  }
  return sites;
}

/// Directions that differ from lane to lane.
Lobe some_lobe() {
  Lobe lobe;
  for (int k = 0; k < Lobe::kDirections; ++k) {
    const Float angle = to_float(Int::iota(0)) * 0.4f + static_cast<float>(k);
    lobe.wi[k] = {0.6f * cos(angle), 0.6f * sin(angle), Float(0.8f)};
    lobe.weight[k] = color_of({0.1f, 0.2f, 0.3f});
  }
  return lobe;
}

TEST(GlossyCache, RecordsGiveTheirHarmonicsTimesTheLobe) {
  // One record with a normal that is not z: its functions and gradients, summed by hand.
  RecordSite site = site_at(0, 0, 0);
  site.n[0] = 0.6f, site.n[2] = 0.8f;
  const GlossyRecords records = records_of(kSomeBands, {site}, 3);
  const GlossyCache cache(records, 0.3f);
  const Vec3 n = everywhere(0.6f, 0, 0.8f), d = everywhere(-0.08f, 0.05f, 0.06f);
  const Lobe lobe = some_lobe();
  const GlossyCache::Light light = cache.look_up(d, n, lobe, Mask::all());
  ASSERT_TRUE(all(light.found));
  const Frame frame = Frame::from_normal(n);
  const Harmonics harmonics(kSomeBands);
  for (int lane = 0; lane < kWidth; ++lane) {
    double expected = 0;
    for (int k = 0; k < Lobe::kDirections; ++k) {
      const Vec3 wi = frame.to_local(lobe.wi[k]);
      const auto h = harmonics_at(harmonics, wi.x.lane(lane), wi.y.lane(lane), wi.z.lane(lane));
      for (std::size_t i = 0; i < h.size(); ++i) {
        const float* const number = records.numbers.data() + i * GlossyRecords::kOfCoefficient;
        const double value = double{number[1]} + double{number[kBands + 1]} * dot(d, frame.x).lane(0) +
                             double{number[2 * kBands + 1]} * dot(d, frame.y).lane(0);
        expected += 0.2 * double{h[i]} * value;
      }
    }
    EXPECT_NEAR(light.value.c[1].lane(lane), expected, 1e-4) << lane;
  }
}

TEST(GlossyCache, LanesDoNotDependOnEachOther) {
  const GlossyCache cache(records_of(4, scattered_sites(300), 5), 0.3f);
  const Lobe lobe = some_lobe();
  std::mt19937 random(6);
  int found = 0;
  for (int i = 0; i < 50; ++i) {
    alignas(64) float x[kWidth], y[kWidth];
    std::uniform_real_distribution<float> place(-1.2f, 1.2f);
    for (int lane = 0; lane < kWidth; ++lane) x[lane] = place(random), y[lane] = place(random);
    const Vec3 p{Float::load(x), Float::load(y), Float(0.0f)}, n = everywhere(0, 0, 1);
    const GlossyCache::Light together = cache.look_up(p, n, lobe, Mask::all());
    for (int lane = 0; lane < kWidth; ++lane) {
      const Mask only = Mask::from_bits(std::uint32_t{1} << lane);
      const GlossyCache::Light alone = cache.look_up(p, n, lobe, only);
      ASSERT_EQ(alone.found.bits(), together.found.bits() & only.bits());
      if (none(alone.found)) continue;
      ++found;
      EXPECT_EQ(alone.value.c[0].lane(lane), together.value.c[0].lane(lane));
    }
  }
  EXPECT_GT(found, 300);
}

TEST(GlossyCache, NeitherOtherSidesNorWhatLiesFarAreReached) {
  const GlossyCache cache(records_of(4, {site_at(0, 0, 0)}, 7), 0.3f);
  const auto found = [&](float x, float nz) {
    return any(cache.look_up(everywhere(x, 0, 0), everywhere(0, 0, nz), some_lobe(), Mask::all()).found);
  };
  EXPECT_TRUE(found(0, 1));
  EXPECT_FALSE(found(0, -1));
  EXPECT_TRUE(found(0.29f, 1));
  EXPECT_FALSE(found(0.31f, 1));
  EXPECT_TRUE(none(GlossyCache({}, 0.3f)
                       .look_up(everywhere(0, 0, 0), everywhere(0, 0, 1), some_lobe(), Mask::all())
                       .found));
}

TEST(GlossyCache, EvenAndGlossySurfacesHaveRecordsOfTheirOwn) {
  IrradianceRecord even{};
  static_cast<RecordSite&>(even) = site_at(0, 0, 0);
  const IrradianceCache cache({even}, 0.3f, records_of(4, {site_at(0.5f, 0, 0)}, 12));
  const auto at = [&](float x, Mask glossy) {
    return any(cache.at_record(everywhere(x, 0, 0), glossy, Mask::all()));
  };
  EXPECT_TRUE(at(0, Mask::none()) && at(0.5f, Mask::all()));
  EXPECT_FALSE(at(0, Mask::all()) || at(0.5f, Mask::none()));
  const auto covered = [&](float x, Mask glossy) {
    return any(cache.covers(everywhere(x, 0, 0), everywhere(0, 0, 1), 0.2f, glossy, Mask::all()));
  };
  EXPECT_TRUE(covered(0.1f, Mask::none()) && covered(0.4f, Mask::all()));
  EXPECT_FALSE(covered(0.1f, Mask::all()) || covered(0.4f, Mask::none()));
}

// ---- blobs

TEST(GlossyBlobs, GiveBackWhatWentIn) {
  const GlossyRecords records = records_of(5, scattered_sites(7), 8);
  GlossyRecords read;
  read.bands = 5;
  ASSERT_TRUE(append_records(blob_of(records), read));
  EXPECT_EQ(blob_of(read), blob_of(records));
  EXPECT_EQ(wire::bands_of(blob_of(records)), 5);
  GlossyRecords none;
  ASSERT_TRUE(append_records(blob_of(GlossyRecords{}), none));
  EXPECT_TRUE(none.sites.empty());
  read.bands = 4;
  EXPECT_FALSE(append_records(blob_of(records), read)) << "other bands";
}

TEST(GlossyBlobs, DamagedBytesAreRefusedOrHarmless) {
  const std::string sound = blob_of(records_of(3, scattered_sites(9), 9));
  for (std::size_t length = 0; length < sound.size(); ++length) {
    GlossyRecords read;
    read.bands = 3;
    EXPECT_FALSE(append_records(std::string_view(sound).substr(0, length), read)) << length;
    EXPECT_TRUE(read.sites.empty() && read.numbers.empty());
  }
  std::mt19937 random(10);
  int refused = 0;
  for (int i = 0; i < 20'000; ++i) {
    std::string blob = sound;
    for (unsigned hits = 1 + random() % 4; hits > 0; --hits)
      blob[random() % blob.size()] = static_cast<char>(random());
    GlossyRecords read;
    read.bands = 3;
    if (!append_records(blob, read)) {
      ++refused;
      EXPECT_TRUE(read.sites.empty() && read.numbers.empty());
      continue;
    }
    // A blob that is let through gives numbers.
    const GlossyCache cache(std::move(read), 0.3f);
    const GlossyCache::Light light =
        cache.look_up(everywhere(0.1f, 0.2f, 0), everywhere(0, 0, 1), some_lobe(), Mask::all());
    for (int c = 0; c < kSpectrumLanes; ++c) EXPECT_TRUE(none(light.found & ~is_finite(light.value.c[c])));
  }
  EXPECT_GT(refused, 1000);
  EXPECT_LT(refused, 19'000) << "most damage is to mantissas alone";
}

TEST(GlossyRecords, TheLastIsTakenBackWhereItIsUnsound) {
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), 1e30f}) {
    GlossyRecords records = records_of(kSomeBands, scattered_sites(3), 4);
    take_back_unsound(records);
    EXPECT_EQ(records.sites.size(), 3u);
    records.numbers.back() = bad;
    take_back_unsound(records);
    EXPECT_EQ(records.sites.size(), 2u);
    GlossyRecords read{.bands = kSomeBands, .sites = {}, .numbers = {}};
    EXPECT_TRUE(append_records(blob_of(records), read));
  }
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA::glossy_records
