// Blobs of phases from workers that lie: who is found out, who is blamed, and what is made anew.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <set>

#include "absl/strings/str_cat.h"
#include "support/phased_job.h"
#include "tessera/v1/blob_ref.pb.h"
#include "unit/server/coordinator_fixture.h"
#include "unit/server/requests.h"
#include "wire/digest.h"
#include "wire/job_check.h"
#include "wire/noise_pilot_blob.h"
#include "wire/phases/blob_arrays.h"
#include "wire/phases/glossy_records.h"
#include "wire/phases/guide_sums.h"
#include "wire/phases/radiosity_links.h"
#include "wire/phases/radiosity_solution.h"
#include "wire/resolve_settings.h"

namespace tessera::server {
namespace {

using ::testing::Contains;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr char kGarbage[] = "no blob of any phase";

/// A blob that no renderer makes of the unit, though it might be one: `seed` is in its numbers.
std::string sound_blob(const v1::JobSpec& spec, const v1::WorkUnit& unit, std::uint32_t seed) {
  const auto expected = wire::expected_blob(spec, unit);
  if (!expected) {  // a phase of the tests' own: inputs, in brackets
    std::string blob = absl::StrCat(seed, "-", unit.index(), "(");
    for (const v1::BlobRef& input : unit.inputs()) absl::StrAppend(&blob, input.digest().substr(0, 8), " ");
    return blob + ")";
  }
  const float value = static_cast<float>(seed) + 1;
  if (expected->check == &wire::kNoisePilotCheck) {
    wire::PilotBlocks pilot = wire::pilot_stripe(expected->blob);
    pilot.values.assign(pilot.count(), {{value, value}, 1});
    return wire::pilot_blob(pilot);
  }
  if (expected->check == &wire::kIrradianceRecordsCheck) {
    wire::IrradianceRecord record{};
    record.n[2] = 1, record.radius = 1, record.irradiance[0] = value;
    wire::GlossyRecords none;
    none.bands = static_cast<int>(expected->blob.glossy_bands);
    return wire::blob_of(std::span(&record, 1)) + wire::blob_of(none);
  }
  if (expected->check == &wire::kGuideSumsCheck)
    return wire::guide_blob({{wire::guide_key::with_bin(wire::guide_key::cell(0, 1, 2, 3, 4), 5), seed, 1}});
  if (expected->check == &wire::kRadiositySolutionCheck) {
    wire::Solution solution;
    solution.sweeps = seed;
    return solution.blob();
  }
  std::string blob;
  wire::put_array(std::vector<wire::RadiosityLink>{{wire::PatchName::of_side(seed), {}, 0.5}}, blob);
  wire::put_array(std::vector<wire::DirectLightBytes>{}, blob);
  wire::put_array(std::vector<std::uint64_t>{0}, blob);
  return blob;
}

class PhaseTrustTest : public CoordinatorTest {
 protected:
  void SetUp() override { start(); }

  /// A job of `integrator`, whose own phases go first where it has any.
  v1::JobSpec spec_of(const std::string& integrator, double noise = 0) {
    v1::JobSpec spec = job_spec();
    spec.mutable_content()->mutable_algorithms()->set_integrator(integrator);
    if (noise > 0) {
      spec.mutable_samples()->set_spp(16);
      spec.mutable_cut()->set_samples_per_unit(16);
      spec.mutable_samples()->set_noise(noise);
    }
    wire::resolve_own_settings({}, *spec.mutable_content()->mutable_algorithms());
    wire::add_phases(spec);
    return spec;
  }
  v1::JobSpec phased_spec() {
    v1::JobSpec spec = job_spec();
    test::add_test_phases(spec, {4, 1});
    return spec;
  }

  /// A worker on a host, and so an identity, of its own.
  struct Maker {
    std::string id;
    std::uint32_t seed = 0;  // written into its blobs: an honest maker has 0
    bool malformed = false;  // its blobs are none
    bool reads_lies = true;  // it makes pixels of whatever blobs there are
  };
  Maker maker(const std::string& host, std::uint32_t seed = 0) {
    grpc::ClientContext context;
    v1::RegisterResponse response;
    EXPECT_TRUE(work_->Register(&context, registration(host), &response).ok());
    return {.id = response.worker_id(), .seed = seed};
  }
  void leave(const Maker& maker) {
    grpc::ClientContext context;
    v1::DeregisterRequest request;
    request.set_worker_id(maker.id);
    v1::DeregisterResponse response;
    EXPECT_TRUE(work_->Deregister(&context, request, &response).ok());
  }
  v1::JobStatus retry(const std::string& job) {
    grpc::ClientContext context;
    v1::RetryJobRequest request;
    request.set_job_id(job);
    v1::RetryJobResponse response;
    EXPECT_TRUE(farm_->RetryJob(&context, request, &response).ok());
    return this->job(job);
  }

  grpc::Status cannot_read(const Maker& maker, const v1::Lease& lease) {
    grpc::ClientContext context;
    v1::FailRequest request;
    request.set_worker_id(maker.id);
    *request.mutable_token() = lease.token();
    request.set_message("a blob is not what the phases make");
    request.set_inputs_fault(true);
    v1::FailResponse response;
    return work_->Fail(&context, request, &response);
  }

  grpc::Status finish(const Maker& maker, const v1::Lease& lease, const v1::JobSpec& spec) {
    const v1::WorkUnit& unit = lease.unit();
    if (!maker.reads_lies) {
      for (const v1::BlobRef& input : unit.inputs()) {
        if (lies_.contains(input.digest())) return cannot_read(maker, lease);
      }
    }
    if (unit.has_tile()) return complete(maker.id, lease, payload_for(unit));
    const std::string blob = maker.malformed ? kGarbage : sound_blob(spec, unit, maker.seed);
    const std::string digest = wire::sha256_hex(blob);
    if (maker.seed != 0) lies_.insert(digest);
    const grpc::Status uploaded = upload(blob);
    EXPECT_TRUE(uploaded.ok() || uploaded.error_code() == grpc::ALREADY_EXISTS) << uploaded.error_message();
    v1::BlobRef ref;
    ref.set_digest(digest);
    ref.set_size_bytes(blob.size());
    return complete(maker.id, lease, ref.SerializeAsString());
  }

  /// Lets them work in turn, on two units at a time, until there is nothing to do for any of them.
  void work(const std::vector<Maker>& makers, const v1::JobSpec& spec) {
    for (int idle = 0, turns = 0; idle < 2 && turns < 2000; ++turns) {
      bool worked = false;
      for (const Maker& maker : makers) {
        const v1::LeaseResponse granted = lease(maker.id, 2);
        for (const v1::Lease& lease : granted.leases()) {
          const grpc::Status status = finish(maker, lease, spec);
          if (maker.malformed && !lease.unit().has_tile()) {
            EXPECT_EQ(status.error_code(), grpc::INVALID_ARGUMENT) << lease.unit().ShortDebugString();
          }
          if (lease.unit().has_tile() && status.ok()) tile_inputs_[lease.unit().index()] = inputs_of(lease);
          worked = true;
        }
      }
      idle = worked ? 0 : idle + 1;
    }
  }
  static std::vector<std::string> inputs_of(const v1::Lease& lease) {
    std::vector<std::string> digests;
    for (const v1::BlobRef& input : lease.unit().inputs()) digests.push_back(input.digest());
    return digests;
  }
  /// Whether no tile was made of what liars made.
  bool tiles_are_right() const {
    for (const auto& [unit, inputs] : tile_inputs_) {
      for (const std::string& digest : inputs) {
        if (lies_.contains(digest)) return false;
      }
    }
    return !tile_inputs_.empty();
  }

  std::set<std::string> lies_;                                     // digests
  std::map<std::uint32_t, std::vector<std::string>> tile_inputs_;  // inputs of the result accepted last
};

TEST_F(PhaseTrustTest, MalformedBlobsAreRefusedAndNobodyElseIsBlamed) {
  const std::vector<std::pair<std::string, double>> kinds = {
      {"path", 0.1}, {"irradiance-cache", 0}, {"guided", 0}, {"radiosity", 0}, {"irradiance-cache", 0.1}};
  int number = 0;
  for (const auto& [integrator, noise] : kinds) {
    const v1::JobSpec spec = spec_of(integrator, noise);
    const std::string id = submit(spec);
    Maker liar = maker(absl::StrCat("liar-", ++number));
    liar.malformed = true;
    const Maker honest = maker(absl::StrCat("honest-", number)),
                other = maker(absl::StrCat("other-", number));
    work({liar, honest, other}, spec);
    const v1::JobStatus status = job(id);
    EXPECT_EQ(status.state(), v1::DONE) << integrator << ": " << status.error();
    EXPECT_GT(status.failures(), 0u) << integrator << ": the liar had no unit of a phase";
    EXPECT_THAT(status.notes(), Not(Contains(HasSubstr("honest")))) << integrator;
    EXPECT_THAT(status.notes(), Not(Contains(HasSubstr("other")))) << integrator;
    for (const Maker& gone : {liar, honest, other}) leave(gone);
  }
}

TEST_F(PhaseTrustTest, ABlobOfTooManyBytesIsNotRead) {
  const v1::JobSpec spec = spec_of("path", 0.1);
  submit(spec);
  const Maker liar = maker("liar");
  const v1::Lease lease = this->lease(liar.id, 1).leases(0);
  const std::string blob(1'000'000, 'x');
  ASSERT_TRUE(upload(blob).ok());
  v1::BlobRef ref;
  ref.set_digest(wire::sha256_hex(blob));
  ref.set_size_bytes(blob.size());
  const grpc::Status status = complete(liar.id, lease, ref.SerializeAsString());
  EXPECT_EQ(status.error_code(), grpc::INVALID_ARGUMENT);
  EXPECT_THAT(status.error_message(), HasSubstr("its blob has 1000000 bytes; at most 208 were expected"));
}

TEST_F(PhaseTrustTest, WrongBlobsAreFoundByOthersWhoMakeThemAgain) {
  for (const char* integrator : {"irradiance-cache", "radiosity", "guided", test::kIntegratorWithPhases}) {
    lies_.clear(), tile_inputs_.clear();
    const bool own = integrator == std::string(test::kIntegratorWithPhases);
    const v1::JobSpec spec = own ? phased_spec() : spec_of(integrator);
    const std::string id = submit(spec);
    const std::string suffix = absl::StrCat("-", integrator);
    const std::vector<Maker> makers = {maker("liar" + suffix, 7), maker("b" + suffix), maker("c" + suffix)};
    work(makers, spec);
    const v1::JobStatus status = job(id);
    EXPECT_EQ(status.state(), v1::DONE) << integrator << ": " << status.error();
    EXPECT_FALSE(lies_.empty());
    EXPECT_TRUE(tiles_are_right()) << integrator;
    EXPECT_THAT(status.notes(), Contains(HasSubstr("liar" + suffix + " is in quarantine"))) << integrator;
    for (const Maker& gone : makers) leave(gone);
  }
}

TEST_F(PhaseTrustTest, WhereTwoDisagreeAndNobodyDecidesTheJobSaysSoAndARetryMakesAllAnew) {
  const v1::JobSpec spec = spec_of("irradiance-cache");
  const std::string id = submit(spec);
  const Maker liar = maker("liar", 7), honest = maker("honest");
  work({liar, honest}, spec);
  EXPECT_EQ(job(id).state(), v1::INCOMPLETE);
  EXPECT_THAT(job(id).error(), HasSubstr("disagree on what it makes, and there is nobody else to decide"));
  // It ends like that again as long as both are there.
  EXPECT_EQ(retry(id).state(), v1::RUNNING);
  work({honest, liar}, spec);
  EXPECT_EQ(job(id).state(), v1::INCOMPLETE);
  leave(liar);
  retry(id);
  work({honest}, spec);
  EXPECT_EQ(job(id).state(), v1::DONE) << job(id).error();
  EXPECT_TRUE(tiles_are_right());
}

TEST_F(PhaseTrustTest, WhoeverCannotReadABlobHasItsMakerSuspected) {
  const v1::JobSpec spec = phased_spec();
  const std::string id = submit(spec);
  const Maker liar = maker("liar", 7);
  // Alone on the farm, it makes the phases and nothing else.
  while (job(id).units_done() < 8) {
    const v1::LeaseResponse leases = lease(liar.id, 1);
    ASSERT_EQ(leases.leases_size(), 1);
    ASSERT_TRUE(finish(liar, leases.leases(0), spec).ok());
  }
  leave(liar);
  Maker b = maker("b"), c = maker("c");
  b.reads_lies = c.reads_lies = false;
  work({b, c}, spec);
  const v1::JobStatus status = job(id);
  EXPECT_EQ(status.state(), v1::DONE) << status.error();
  EXPECT_TRUE(tiles_are_right());
  EXPECT_EQ(status.failures(), 0u) << "the readers are not to blame";
  EXPECT_THAT(status.notes(), Contains(HasSubstr("made again by others")));
  EXPECT_THAT(status.notes(), Contains(HasSubstr("liar is in quarantine")));
}

TEST_F(PhaseTrustTest, OneHonestHostAloneGetsARightPictureByARetry) {
  const v1::JobSpec spec = phased_spec();
  const std::string id = submit(spec);
  const Maker liar = maker("liar", 7);
  while (job(id).units_done() < 8) ASSERT_TRUE(finish(liar, lease(liar.id, 1).leases(0), spec).ok());
  leave(liar);
  Maker honest = maker("honest");
  honest.reads_lies = false;
  work({honest}, spec);
  EXPECT_EQ(job(id).state(), v1::INCOMPLETE);
  EXPECT_THAT(job(id).error(), HasSubstr("disagree"));
  for (int tries = 0; tries < 8 && job(id).state() == v1::INCOMPLETE; ++tries) {
    retry(id);
    work({honest}, spec);
  }
  EXPECT_EQ(job(id).state(), v1::DONE) << job(id).error();
  EXPECT_TRUE(tiles_are_right());
}

TEST_F(PhaseTrustTest, AReaderWhoComplainsInVainIsToBlame) {
  const v1::JobSpec spec = phased_spec();
  const std::string id = submit(spec);
  const Maker honest = maker("honest");
  while (job(id).units_done() < 8) ASSERT_TRUE(finish(honest, lease(honest.id, 1).leases(0), spec).ok());
  const Maker reader = maker("reader");
  ASSERT_TRUE(cannot_read(reader, lease(reader.id, 1).leases(0)).ok());
  EXPECT_EQ(job(id).failures(), 0u);
  EXPECT_THAT(lease(honest.id, 1).leases(), IsEmpty()) << "the picture waits";
  // It makes all eight blobs again, and gets the same.
  for (int unit = 0; unit < 8; ++unit) {
    const v1::LeaseResponse leases = lease(reader.id, 1);
    ASSERT_EQ(leases.leases_size(), 1) << unit;
    EXPECT_EQ(leases.leases(0).unit().index(), static_cast<std::uint32_t>(unit));
    EXPECT_TRUE(finish(reader, leases.leases(0), spec).ok());
  }
  const v1::LeaseResponse leases = lease(reader.id, 1);
  ASSERT_EQ(leases.leases_size(), 1);
  ASSERT_TRUE(leases.leases(0).unit().has_tile());
  ASSERT_TRUE(cannot_read(reader, leases.leases(0)).ok());
  EXPECT_EQ(job(id).failures(), 1u) << "two have made the same blobs";
  // The reader, too: its opinion is asked for where a unit of the other's is audited.
  work({honest, reader}, spec);
  EXPECT_EQ(job(id).state(), v1::DONE);
  EXPECT_THAT(job(id).notes(), Not(Contains(HasSubstr("quarantine"))));
}

TEST_F(PhaseTrustTest, WhereNobodyCanBeAskedARetryMakesTheBlobsAnew) {
  const v1::JobSpec spec = phased_spec();
  const std::string id = submit(spec);
  Maker alone = maker("alone", 7);  // whose disk lies, say, and is mended later
  alone.reads_lies = false;
  work({alone}, spec);
  EXPECT_EQ(job(id).state(), v1::INCOMPLETE);
  alone.seed = 0;
  EXPECT_EQ(retry(id).units_done(), 0u);
  work({alone}, spec);
  EXPECT_EQ(job(id).state(), v1::DONE) << job(id).error();
  EXPECT_TRUE(tiles_are_right());
}

TEST_F(PhaseTrustTest, OneIdentityAloneIsNotHeldUp) {
  const v1::JobSpec spec = spec_of("irradiance-cache", 0.1);
  const std::string id = submit(spec);
  work({maker("alone")}, spec);
  EXPECT_EQ(job(id).state(), v1::DONE) << job(id).error();
  EXPECT_EQ(job(id).audits(), 0u);
}

}  // namespace
}  // namespace tessera::server
