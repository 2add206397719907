// Interpolating records, and the blobs that hold them.
#include "render/textbook/irradiance_cache/cache.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

namespace tessera::render::TESSERA_ISA {
namespace {

constexpr float kError = 0.3f;

IrradianceRecord record_at(float x, float y, float z, float radius) {
  IrradianceRecord record{};
  record.p[0] = x, record.p[1] = y, record.p[2] = z;
  record.n[2] = 1;
  record.radius = radius;
  record.pixel = 0.01f;
  for (float& band : record.irradiance) band = 1;
  return record;
}

/// Records over the square [-1, 1] x [-1, 1] of the plane z = 0, of radii from 0.3 to 2.
std::vector<IrradianceRecord> scattered(int n, std::uint32_t seed = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> place(-1, 1), radius(0.3f, 2);
  std::vector<IrradianceRecord> records;
  for (int i = 0; i < n; ++i) {
    const float x = place(random), y = place(random);
    records.push_back(record_at(x, y, 0, radius(random)));
  }
  return records;
}

const Vec3 kUp{Float(0.0f), Float(0.0f), Float(1.0f)};

/// 16 points of the square.
Vec3 points(std::mt19937& random) {
  alignas(64) float x[kWidth], y[kWidth];
  std::uniform_real_distribution<float> place(-1.2f, 1.2f);
  for (int i = 0; i < kWidth; ++i) x[i] = place(random), y[i] = place(random);
  return {Float::load(x), Float::load(y), Float(0.0f)};
}

TEST(IrradianceCache, EvenLightIsFoundExactly) {
  const IrradianceCache cache(scattered(200), kError);
  std::mt19937 random(2);
  int found = 0;
  for (int i = 0; i < 100; ++i) {
    const Irradiance light = cache.look_up(points(random), kUp, Mask::all());
    found += count(light.found);
    // A mean of ones: two roundings a record, and those of the division.
    EXPECT_TRUE(none(light.found & (abs(light.value.c[1] - 1.0f) > 1e-5f)));
  }
  EXPECT_GT(found, 1000);
  EXPECT_LT(found, 1600) << "beyond the square is none";
}

TEST(IrradianceCache, LightThatGrowsEvenlyIsExtrapolatedExactly) {
  // 8 + 2x - 3y, as the records' gradients say.
  std::vector<IrradianceRecord> records = scattered(200);
  for (IrradianceRecord& r : records) {
    r.irradiance[0] = 8 + 2 * r.p[0] - 3 * r.p[1];
    r.translation[0][0] = 2, r.translation[0][1] = -3;
  }
  const IrradianceCache cache(std::move(records), kError);
  std::mt19937 random(3);
  for (int i = 0; i < 100; ++i) {
    const Vec3 p = points(random);
    const Irradiance light = cache.look_up(p, kUp, Mask::all());
    const Float expected = 8.0f + 2.0f * p.x - 3.0f * p.y;
    EXPECT_TRUE(none(light.found & (abs(light.value.c[0] - expected) > 1e-4f)));
  }
}

TEST(IrradianceCache, TurnedNormalsFollowTheRotation) {
  // Light from +x: a turn about +y by a brings 1 + 2 sin a.
  IrradianceRecord record = record_at(0, 0, 0, 1);
  record.rotation[0][1] = 2;
  const IrradianceCache cache({record}, kError);
  const float a = 0.1f;
  const Irradiance light = cache.look_up({Float(0.0f), Float(0.0f), Float(0.0f)},
                                         {Float(std::sin(a)), Float(0.0f), Float(std::cos(a))}, Mask::all());
  ASSERT_TRUE(all(light.found));
  EXPECT_NEAR(light.value.c[0].lane(0), 1 + 2 * std::sin(a), 1e-5);
}

TEST(IrradianceCache, NeitherOtherSidesNorWhatLiesBehindAreReached) {
  const IrradianceCache cache({record_at(0, 0, 0, 1)}, kError);
  const auto found = [&](float z, Vec3 n) {
    return any(cache.look_up({Float(0.0f), Float(0.0f), Float(z)}, n, Mask::all()).found);
  };
  EXPECT_TRUE(found(0, kUp));
  EXPECT_FALSE(found(0, -kUp)) << "the other side of a thin wall";
  EXPECT_TRUE(found(0.1f, kUp));
  EXPECT_FALSE(found(-0.1f, kUp)) << "a hollow";
  EXPECT_FALSE(found(0.31f, kUp)) << "beyond the error";
}

TEST(IrradianceCache, LightIsNeverNegative) {
  IrradianceRecord record = record_at(0, 0, 0, 1);
  record.translation[0][0] = -100;
  const IrradianceCache cache({record}, kError);
  const Irradiance light = cache.look_up({Float(0.2f), Float(0.0f), Float(0.0f)}, kUp, Mask::all());
  ASSERT_TRUE(all(light.found));
  EXPECT_EQ(light.value.c[0].lane(0), 0);
}

TEST(IrradianceCache, WeightsFallToZeroWithoutAStep) {
  // Two records that see other light: along the line between them the mean changes by no more than its
  // steepest slope allows, which is below 4 / (0.3 * 1) here, times the step of 0.6 / 1000.
  IrradianceRecord dark = record_at(-0.1f, 0, 0, 1), bright = record_at(0.1f, 0, 0, 1);
  bright.irradiance[0] = 2;
  const IrradianceCache cache({dark, bright}, kError);
  float last = 1;
  for (int i = 0; i <= 1000; ++i) {
    const float x = -0.3f + 0.6f * static_cast<float>(i) / 1000;
    const Irradiance light = cache.look_up({Float(x), Float(0.0f), Float(0.0f)}, kUp, Mask::all());
    ASSERT_TRUE(all(light.found)) << x;
    const float value = light.value.c[0].lane(0);
    EXPECT_GE(value, last - 1e-5f) << x;
    EXPECT_LE(value, last + 4 / 0.3f * 0.0006f) << x;
    last = value;
  }
  EXPECT_EQ(last, 2);
}

TEST(IrradianceCache, TheHierarchyFindsWhatAllRecordsAre) {
  const std::vector<IrradianceRecord> records = scattered(500);
  const IrradianceCache cache(records, kError);
  std::mt19937 random(4);
  for (int i = 0; i < 100; ++i) {
    const Vec3 p = points(random);
    Mask covered = Mask::none();
    for (const IrradianceRecord& record : records)
      covered |= split_sphere_error(record, p, kUp) < 0.7f * kError;
    EXPECT_EQ(cache.covers(p, kUp, 0.7f * kError, Mask::none(), Mask::all()).bits(), covered.bits());
    EXPECT_TRUE(none(and_not(covered, cache.look_up(p, kUp, Mask::all()).found)));
  }
}

TEST(IrradianceCache, LanesDoNotDependOnEachOther) {
  std::vector<IrradianceRecord> records = scattered(500);
  std::mt19937 random(5);
  for (IrradianceRecord& record : records)
    record.irradiance[0] = std::uniform_real_distribution<float>(0, 9)(random);
  const IrradianceCache cache(std::move(records), kError);
  for (int i = 0; i < 50; ++i) {
    const Vec3 p = points(random);
    const Irradiance together = cache.look_up(p, kUp, Mask::all());
    for (int lane = 0; lane < kWidth; ++lane) {
      const Vec3 same{Float(p.x.lane(lane)), Float(p.y.lane(lane)), Float(0.0f)};
      const Irradiance alone = cache.look_up(same, kUp, Mask::first(1));
      ASSERT_EQ((together.found.bits() >> lane) & 1, alone.found.bits() & 1);
      EXPECT_EQ(together.value.c[0].lane(lane), alone.value.c[0].lane(0));
    }
  }
}

TEST(IrradianceCache, NoRecordsAnswerNothing) {
  const IrradianceCache cache({}, kError);
  std::mt19937 random(6);
  EXPECT_TRUE(none(cache.look_up(points(random), kUp, Mask::all()).found));
}

TEST(IrradianceCache, RecordsAtOnePlaceAreAllFound) {
  std::vector<IrradianceRecord> records(1000, record_at(0, 0, 0, 1));
  const IrradianceCache cache(std::move(records), kError);
  EXPECT_TRUE(all(cache.look_up({Float(0.0f), Float(0.0f), Float(0.0f)}, kUp, Mask::all()).found));
}

// ---- blobs

TEST(RecordBlobs, GiveBackWhatWentIn) {
  const std::vector<IrradianceRecord> records = scattered(7);
  std::vector<IrradianceRecord> read;
  ASSERT_TRUE(append_records(blob_of(records), read));
  ASSERT_TRUE(append_records(blob_of(std::vector<IrradianceRecord>{}), read));
  ASSERT_EQ(read.size(), records.size());
  EXPECT_EQ(std::memcmp(read.data(), records.data(), sizeof(records[0]) * records.size()), 0);
}

TEST(RecordBlobs, OtherLengthsAreRefused) {
  const std::string blob = blob_of(scattered(3));
  std::vector<IrradianceRecord> read;
  for (std::size_t length = 0; length < blob.size(); ++length)
    EXPECT_FALSE(append_records(std::string_view(blob).substr(0, length), read)) << length;
  EXPECT_FALSE(append_records(blob + "x", read));
  EXPECT_FALSE(append_records(blob + std::string(sizeof(IrradianceRecord), '\0'), read));
  EXPECT_TRUE(read.empty());
}

TEST(RecordBlobs, NumbersThatNoRecordHasAreRefused) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  const auto refused = [](auto&& damage) {
    std::vector<IrradianceRecord> records = scattered(3), read;
    damage(records[1]);
    return !append_records(blob_of(records), read) && read.empty();
  };
  EXPECT_TRUE(refused([&](IrradianceRecord& r) { r.p[0] = nan; }));
  EXPECT_TRUE(refused([&](IrradianceRecord& r) { r.p[1] = inf; }));
  EXPECT_TRUE(refused([&](IrradianceRecord& r) { r.n[2] = 2; }));
  EXPECT_TRUE(refused([&](IrradianceRecord& r) { r.radius = 0; }));
  EXPECT_TRUE(refused([&](IrradianceRecord& r) { r.radius = -1; }));
  EXPECT_TRUE(refused([&](IrradianceRecord& r) { r.irradiance[2] = -1e-3f; }));
  EXPECT_TRUE(refused([&](IrradianceRecord& r) { r.rotation[2][2] = nan; }));
  EXPECT_TRUE(refused([&](IrradianceRecord& r) { r.translation[0][1] = -inf; }));
  EXPECT_FALSE(refused([](IrradianceRecord&) {}));
}

TEST(RecordBlobs, DamagedBytesAreRefusedOrHarmless) {
  const std::string sound = blob_of(scattered(20));
  std::mt19937 random(7);
  int refused = 0;
  for (int i = 0; i < 20'000; ++i) {
    std::string blob = sound;
    for (unsigned hits = 1 + random() % 4; hits > 0; --hits)
      blob[random() % blob.size()] = static_cast<char>(random());
    if (random() % 8 == 0) blob.resize(random() % blob.size());
    std::vector<IrradianceRecord> read;
    if (!append_records(blob, read)) {
      ++refused;
      EXPECT_TRUE(read.empty());
      continue;
    }
    // A blob that is let through gives numbers.
    const IrradianceCache cache(std::move(read), kError);
    const Irradiance light = cache.look_up(points(random), kUp, Mask::all());
    for (int c = 0; c < kSpectrumLanes; ++c) EXPECT_TRUE(none(light.found & ~(light.value.c[c] >= 0.0f)));
  }
  EXPECT_GT(refused, 2000);
  EXPECT_LT(refused, 19'000) << "some damage is to mantissas alone";
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA
