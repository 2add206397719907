// A farm of machines that round differently: who may work on what, what is said of it, and what is taken
// over.
#include <gmock/gmock.h>

#include "support/process/temp_dir.h"
#include "unit/server/coordinator_fixture.h"
#include "unit/server/requests.h"

namespace tessera::server {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr char kIntel[] = "avx512/embree-3.13.5/11111111";
constexpr char kAmd[] = "avx512/embree-3.13.5/22222222";

class MixedFarmTest : public CoordinatorTest {
 protected:
  void SetUp() override { start(directory_.path()); }

  std::string register_as(const std::string& name, const std::string& arithmetic_class) {
    v1::RegisterRequest request = registration(name, "avx512");
    request.set_arithmetic_classes(0, arithmetic_class);
    grpc::ClientContext context;
    v1::RegisterResponse response;
    const grpc::Status status = work_->Register(&context, request, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return response.worker_id();
  }

  /// Leases and renders up to so many units; how many there were.
  int render(const std::string& worker, int units) {
    for (int done = 0; done < units; ++done) {
      const v1::LeaseResponse granted = lease(worker, 1);
      if (granted.leases().empty()) return done;
      EXPECT_TRUE(complete(worker, granted.leases(0), payload_for(granted.leases(0).unit())).ok());
    }
    return units;
  }

  std::string continued_from(const v1::JobSpec& spec, const std::string& donor) {
    grpc::ClientContext context;
    v1::SubmitJobRequest request;
    request.set_request_id("request " + std::to_string(++requests_));
    *request.mutable_spec() = spec;
    request.set_continued(donor);
    v1::SubmitJobResponse response;
    const grpc::Status status = farm_->SubmitJob(&context, request, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return response.job_id();
  }

  v1::JobSpec spec_with(v1::Bits bits, std::uint32_t ranges = 1) {
    v1::JobSpec spec = job_spec(ranges);
    spec.mutable_farm()->set_bits(bits);
    return spec;
  }

  support::TempDir directory_;
};

TEST_F(MixedFarmTest, SaysWhoIsLeftOut) {
  const std::string intel = register_as("intel", kIntel), amd = register_as("amd", kAmd);
  register_as("intel2", kIntel);
  const std::string id = submit(spec_with(v1::BITS_SAME));
  EXPECT_EQ(lease(amd, 1).leases_size(), 0) << "most threads are Intel's, whoever asks first";
  EXPECT_EQ(render(intel, 1), 1);

  const v1::JobStatus status = job(id);
  EXPECT_THAT(status.arithmetic_classes(), ElementsAre(kIntel));
  EXPECT_EQ(status.isa(), "avx512");
  EXPECT_THAT(status.left_out(), HasSubstr("1 worker (2 threads) of class " + std::string(kAmd)));
  grpc::ClientContext context;
  v1::ListWorkersResponse workers;
  ASSERT_TRUE(farm_->ListWorkers(&context, {}, &workers).ok());
  for (const v1::WorkerStatus& worker : workers.workers()) {
    const bool is_amd = worker.name() == "amd";
    EXPECT_THAT(worker.arithmetic().classes(), ElementsAre(is_amd ? kAmd : kIntel));
    const auto& closed = worker.arithmetic().closed_jobs();
    EXPECT_EQ(std::vector<std::string>(closed.begin(), closed.end()),
              is_amd ? std::vector<std::string>{id} : std::vector<std::string>{});
  }
}

TEST_F(MixedFarmTest, WorksOnAJobForEveryMachineAndRemembersWhoDid) {
  const std::string intel = register_as("intel", kIntel), amd = register_as("amd", kAmd);
  const std::string id = submit(spec_with(v1::BITS_ANY));
  EXPECT_EQ(render(amd, 1), 1);
  EXPECT_EQ(render(intel, 3), 3);
  for (const bool restarted : {false, true}) {
    if (restarted) start(directory_.path());
    const v1::JobStatus status = job(id);
    EXPECT_EQ(status.state(), v1::DONE);
    EXPECT_THAT(status.arithmetic_classes(), ElementsAre(kIntel, kAmd));
    EXPECT_THAT(status.left_out(), IsEmpty());
  }
}

TEST_F(MixedFarmTest, TakesOverResultsOfOneClassIntoAJobOfOne) {
  std::string intel = register_as("intel", kIntel), amd = register_as("amd", kAmd);
  const std::string mixed = submit(spec_with(v1::BITS_ANY));
  EXPECT_EQ(render(amd, 1), 1);
  EXPECT_EQ(render(intel, 3), 3);

  EXPECT_EQ(job(submit(spec_with(v1::BITS_ANY))).units_adopted(), 4U);
  const std::string same = submit(spec_with(v1::BITS_SAME, 2));
  EXPECT_EQ(job(same).units_adopted(), 3U) << "Intel's, of which there are most";
  EXPECT_EQ(lease(amd, 8).leases_size(), 0);
  EXPECT_EQ(lease(intel, 8).leases_size(), 5);

  // Where only the others are left, their rest would never come: all is rendered again, unless the job was
  // named.
  start(directory_.path());
  amd = register_as("amd", kAmd);
  const v1::JobSpec more = spec_with(v1::BITS_SAME, 3);
  EXPECT_EQ(job(submit(more)).units_adopted(), 0U);
  const std::string named = continued_from(more, mixed);
  EXPECT_EQ(job(named).units_adopted(), 3U);
  EXPECT_THAT(job(named).waiting_for(), HasSubstr(kIntel));
}

TEST_F(MixedFarmTest, HasDefaultsForJobsThatDoNotSay) {
  EXPECT_EQ(get_job(submit(job_spec())).spec().farm().bits(), v1::BITS_SAME);
  CoordinatorOptions options;
  options.same_bits = false;
  options.isa = "avx2";
  start(std::move(options));
  const v1::JobSpec silent = get_job(submit(job_spec())).spec();
  EXPECT_EQ(silent.farm().bits(), v1::BITS_ANY);
  EXPECT_EQ(silent.farm().isa(), "avx2");
  v1::JobSpec said = spec_with(v1::BITS_SAME);
  said.mutable_farm()->set_isa("avx512");
  said = get_job(submit(said)).spec();
  EXPECT_EQ(said.farm().bits(), v1::BITS_SAME);
  EXPECT_EQ(said.farm().isa(), "avx512");
}

TEST_F(MixedFarmTest, RefusesWorkersThatDoNotSayHowTheyRound) {
  const v1::RegisterRequest sound = registration("worker", "avx512");
  v1::RegisterRequest none = sound, other = sound, long_one = sound;
  none.clear_arithmetic_classes();
  other.set_arithmetic_classes(0, "avx2/embree-3.13.5/11111111");
  long_one.set_arithmetic_classes(0, "avx512/" + std::string(1000, 'x'));
  for (const v1::RegisterRequest& request : {none, other, long_one}) {
    grpc::ClientContext context;
    v1::RegisterResponse response;
    EXPECT_EQ(work_->Register(&context, request, &response).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  }
}

}  // namespace
}  // namespace tessera::server
