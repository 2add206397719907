// Blobs of phases, as the coordinator checks them.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>

#include "wire/algorithm.h"
#include "wire/job_check.h"
#include "wire/noise_pilot_blob.h"
#include "wire/phases/blob_arrays.h"
#include "wire/phases/glossy_records.h"
#include "wire/phases/guide_sums.h"
#include "wire/phases/radiosity_links.h"
#include "wire/phases/radiosity_solution.h"
#include "wire/resolve_settings.h"

namespace tessera::wire {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

v1::JobSpec spec_of(const std::string& integrator) {
  v1::JobSpec spec;
  spec.mutable_content()->mutable_algorithms()->set_integrator(integrator);
  resolve_own_settings({}, *spec.mutable_content()->mutable_algorithms());
  spec.mutable_cut()->mutable_crop()->set_x1(640);
  spec.mutable_cut()->mutable_crop()->set_y1(480);
  add_phases(spec);
  return spec;
}

v1::WorkUnit part(std::uint32_t phase, std::uint32_t number) {
  v1::WorkUnit unit;
  unit.mutable_part()->set_phase(phase);
  unit.mutable_part()->set_part(number);
  return unit;
}

v1::WorkUnit merge(std::uint32_t phase, std::uint32_t level, std::uint32_t index) {
  v1::WorkUnit unit;
  unit.mutable_merge()->set_phase(phase);
  unit.mutable_merge()->set_level(level);
  unit.mutable_merge()->set_index(index);
  return unit;
}

/// Why the blob is refused; empty where it is not.
std::string fault(const PhaseBlobCheck& check, std::string_view bytes, const PhaseBlob& job) {
  const char* const why = check.fault(bytes, job);
  return why == nullptr ? "" : why;
}

/// Corpus of the fuzz target, which has a byte for the kind in front.
std::string sound(const std::string& name) {
  std::ifstream file("tests/fuzz/corpus/phase_blob/sound-" + name, std::ios::binary);
  return {std::istreambuf_iterator<char>(file.ignore(1)), {}};
}
const PhaseBlob kJob{.parts = 2, .crop = {0, 0, 64, 32}, .glossy_bands = 3, .memory_limit = 1 << 20};

template <class T>
std::string with(std::string bytes, std::size_t at, T value) {
  std::memcpy(bytes.data() + at, &value, sizeof(value));
  return bytes;
}

TEST(PhaseBlobs, EveryPhaseOfEveryAlgorithmHasACheck) {
  for (const AlgorithmTraits& algorithm : algorithms()) {
    for (const PhaseTraits& phase : algorithm.phases)
      EXPECT_NE(phase.check, nullptr) << algorithm.name << ", phase " << phase.name;
  }
  v1::JobSpec spec = spec_of("path");
  spec.mutable_samples()->set_noise(0.1);
  add_phases(spec);
  ASSERT_TRUE(expected_blob(spec, part(0, 0)).has_value());
  EXPECT_EQ(expected_blob(spec, part(0, 0))->check, &kNoisePilotCheck);
}

TEST(PhaseBlobs, MergesHaveThePartsBelowThem) {
  const v1::JobSpec spec = spec_of("irradiance-cache");  // 64 parts, merged eight at a time
  const auto parts = [&](const v1::WorkUnit& unit) {
    const PhaseBlob blob = expected_blob(spec, unit)->blob;
    return std::pair(blob.first_part, blob.end_part);
  };
  EXPECT_EQ(parts(part(1, 17)), std::pair(17u, 18u));
  EXPECT_EQ(parts(merge(0, 1, 3)), std::pair(24u, 32u));
  EXPECT_EQ(parts(merge(0, 2, 0)), std::pair(0u, 64u));
  EXPECT_FALSE(expected_blob(spec, part(2, 0)).has_value()) << "there is no such phase";
  EXPECT_EQ(expected_blob(spec, part(0, 0))->blob.glossy_bands,
            spec.content().algorithms().irradiance_cache().glossy_bands());
}

TEST(PhaseBlobs, OfAnyOtherLengthAreRefused) {
  const std::pair<const char*, const PhaseBlobCheck*> all[] = {
      {"irradiance-records", &kIrradianceRecordsCheck},
      {"glossy-records", &kIrradianceRecordsCheck},
      {"guide-sums", &kGuideSumsCheck},
      {"estimate-links", &kEstimateLinksCheck},
      {"patch-links", &kPatchLinksCheck},
      {"solution", &kRadiositySolutionCheck},
      {"noise-pilot", &kNoisePilotCheck}};
  for (const auto& [name, check] : all) {
    const std::string blob = sound(name);
    ASSERT_FALSE(blob.empty()) << name;
    EXPECT_EQ(fault(*check, blob, kJob), "") << name;
    EXPECT_GE(check->most_bytes(kJob), blob.size()) << name;
    EXPECT_NE(fault(*check, blob + "x", kJob), "") << name;
    for (std::size_t length = 0; length < blob.size(); ++length) {
      if (check == &kGuideSumsCheck && length % sizeof(GuideSum) == 0) continue;  // fewer sums
      EXPECT_NE(fault(*check, std::string_view(blob).substr(0, length), kJob), "") << name << " " << length;
    }
  }
}

TEST(PhaseBlobs, RecordsHaveUsualNumbersAndTheJobsBands) {
  const std::string blob = sound("irradiance-records");
  constexpr std::size_t kHeader = 16;
  for (const std::size_t at : {std::size_t{0}, sizeof(RecordSite), sizeof(IrradianceRecord) - sizeof(float)})
    EXPECT_NE(fault(kIrradianceRecordsCheck, with(blob, kHeader + at, kNaN), kJob), "") << at;
  EXPECT_NE(fault(kIrradianceRecordsCheck, with(blob, kHeader + sizeof(RecordSite), -1.0f), kJob), "");
  PhaseBlob other = kJob;
  other.glossy_bands = 4;
  EXPECT_EQ(fault(kIrradianceRecordsCheck, blob, other), "records of other bands than the job asks for");
  const std::vector<IrradianceRecord> many(kMostRecordBytes / sizeof(IrradianceRecord) + 1, [] {
    IrradianceRecord record{};
    record.n[0] = record.radius = 1;
    return record;
  }());
  GlossyRecords none;
  none.bands = 3;
  const std::string large = blob_of(many) + blob_of(none);
  EXPECT_EQ(fault(kIrradianceRecordsCheck, large, kJob), "more records than its parts have room for");
  PhaseBlob two = kJob;
  two.end_part = 2;
  EXPECT_EQ(fault(kIrradianceRecordsCheck, large, two), "");
}

TEST(PhaseBlobs, PilotsAreOfTheirOwnStripe) {
  const std::string blob = sound("noise-pilot");
  PhaseBlob other = kJob;
  other.first_part = 1, other.end_part = 2;
  EXPECT_EQ(fault(kNoisePilotCheck, blob, other), "a pilot of other blocks of the picture than its own");
  other.first_part = 0;
  EXPECT_EQ(fault(kNoisePilotCheck, blob, other), "a pilot of other blocks of the picture than its own");
  EXPECT_EQ(fault(kNoisePilotCheck, with(blob, blob.size() - sizeof(float), kNaN), kJob),
            "no pilot of a picture's noise");
  // Some parts have nothing where there are more of them than rows.
  PhaseBlob empty = kJob;
  empty.parts = 1000;
  EXPECT_EQ(fault(kNoisePilotCheck, "", empty), "");
  EXPECT_NE(fault(kNoisePilotCheck, blob, empty), "");
}

TEST(PhaseBlobs, LinksLeadFromSidesToPatchesInOrder) {
  const auto blob_of_links = [](const std::vector<RadiosityLink>& links) {
    std::string blob;
    put_array(links, blob);
    put_array(std::vector<DirectLightBytes>{}, blob);
    put_array(std::vector<std::uint64_t>{0}, blob);
    return blob;
  };
  const auto refused = [&](const std::vector<RadiosityLink>& links, const PhaseBlobCheck& check) {
    return !fault(check, blob_of_links(links), kJob).empty();
  };
  const PatchName side = PatchName::of_side(4), cluster = PatchName::of_cluster(1);
  EXPECT_FALSE(refused({{side, cluster, 0.5}}, kEstimateLinksCheck));
  EXPECT_TRUE(refused({{cluster, side, 0.5}}, kEstimateLinksCheck));
  EXPECT_TRUE(refused({{side, side, 1.5}}, kPatchLinksCheck));
  EXPECT_TRUE(refused({{side, side, std::nan("")}}, kPatchLinksCheck));
  EXPECT_TRUE(refused({{side, side, 0.5}, {PatchName::of_side(3), side, 0.5}}, kPatchLinksCheck));
  EXPECT_FALSE(refused({{side.part(1), side, 0.5}}, kPatchLinksCheck));
  EXPECT_TRUE(refused({{side.part(1), side, 0.5}}, kEstimateLinksCheck)) << "the estimate has whole sides";
}

TEST(PhaseBlobs, SolutionsAreFinite) {
  const std::string blob = sound("solution");
  Solution solution = Solution::read(blob).value();
  solution.vertices[2].radiosity[1] = kNaN;
  EXPECT_NE(fault(kRadiositySolutionCheck, solution.blob(), kJob), "");
  solution = Solution::read(blob).value();
  solution.patches[0].irradiance[0] = std::numeric_limits<float>::infinity();
  EXPECT_NE(fault(kRadiositySolutionCheck, solution.blob(), kJob), "");
}

}  // namespace
}  // namespace tessera::wire
