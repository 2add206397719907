// What a job tells of the hosts that worked on it: who was slow, and who is not to be trusted.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "coordinator_fixture.h"
#include "requests.h"
#include "support/temp_dir.h"

namespace tessera::server {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;

class Hosts : public CoordinatorTest {
 protected:
  std::string register_host(const std::string& host) {
    grpc::ClientContext context;
    v1::RegisterRequest request = registration(host);
    request.set_threads(4);
    v1::RegisterResponse response;
    EXPECT_TRUE(work_->Register(&context, request, &response).ok());
    return response.worker_id();
  }
  grpc::StatusCode bring(const std::string& worker, const v1::Lease& lease, int seed, std::int64_t seconds) {
    grpc::ClientContext context;
    v1::CompleteRequest request;
    request.set_worker_id(worker);
    *request.mutable_token() = lease.token();
    request.set_payload(payload_for(lease.unit(), seed));
    request.mutable_stats()->mutable_wall_time()->set_seconds(seconds);
    v1::CompleteResponse response;
    return work_->Complete(&context, request, &response).error_code();
  }
  v1::GetJobResponse all_of(const std::string& id) {
    grpc::ClientContext context;
    v1::GetJobRequest request;
    request.set_job_id(id);
    v1::GetJobResponse response;
    EXPECT_TRUE(farm_->GetJob(&context, request, &response).ok());
    return response;
  }
  std::vector<std::string> notes_of(const std::string& id) {
    const v1::JobStatus status = job(id);
    return {status.notes().begin(), status.notes().end()};
  }
};

TEST_F(Hosts, SlowOnesAreNamed) {
  const support::TempDir folder;
  start(folder.path());
  const std::string id = submit(job_spec(/*ranges=*/4));  // sixteen units
  // Any lease of the job's generation counts, whoever brings the result.
  std::vector<v1::Lease> leases;
  const std::string first = register_host("usual"), second = register_host("as usual"), third = register_host("slow");
  while (leases.size() < 12) {
    const std::size_t before = leases.size();
    for (const std::string& worker : {first, second, third}) {
      const v1::LeaseResponse more = lease(worker, 16);
      leases.insert(leases.end(), more.leases().begin(), more.leases().end());
    }
    ASSERT_GT(leases.size(), before);
  }
  for (std::size_t i = 0; i < 12; ++i) {
    const bool slow = i % 3 == 2;
    ASSERT_EQ(bring(i % 3 == 0 ? first : slow ? third : second, leases[i], 0, slow ? 30 : 10), grpc::StatusCode::OK);
  }
  for (int round = 0; round < 2; ++round) {
    const v1::GetJobResponse response = all_of(id);
    EXPECT_EQ(response.usual_unit_time().seconds(), 10);
    ASSERT_EQ(response.slow_hosts_size(), 1);
    EXPECT_EQ(response.slow_hosts(0).host(), "slow");
    EXPECT_EQ(response.slow_hosts(0).unit_time().seconds(), 30);
    EXPECT_EQ(response.slow_hosts(0).units(), 4u);
    start(folder.path());  // it is known to the next coordinator too
  }
}

TEST_F(Hosts, AFinishedJobTellsOfResultsByALiar) {
  const support::TempDir folder;
  start(folder.path());
  const std::string liar = register_host("liar"), honest = register_host("honest"), third = register_host("third");
  const std::string over = submit(job_spec());
  const v1::LeaseResponse leases = lease(liar, 16);
  ASSERT_GT(leases.leases_size(), 0);
  for (const v1::Lease& lease : leases.leases()) ASSERT_EQ(bring(liar, lease, 0, 1), grpc::StatusCode::OK);
  while (job(over).state() != v1::DONE) {
    const v1::LeaseResponse rest = lease(honest, 16);
    for (const v1::Lease& lease : rest.leases()) ASSERT_EQ(bring(honest, lease, 0, 1), grpc::StatusCode::OK);
  }
  EXPECT_THAT(notes_of(over), Not(Contains(HasSubstr("liar"))));

  v1::JobSpec spec = job_spec();
  spec.mutable_settings()->set_seed(2);
  const std::string open = submit(spec);
  const v1::LeaseResponse others = lease(liar, 1);
  ASSERT_EQ(others.leases_size(), 1);
  const v1::Lease& disputed = others.leases(0);
  ASSERT_EQ(bring(liar, disputed, 666, 1), grpc::StatusCode::OK);
  EXPECT_EQ(bring(honest, disputed, 0, 1), grpc::StatusCode::ALREADY_EXISTS);
  EXPECT_EQ(bring(third, disputed, 0, 1), grpc::StatusCode::ALREADY_EXISTS);
  const std::string told = std::to_string(leases.leases_size()) + " units are of host liar";
  for (int round = 0; round < 2; ++round) {
    EXPECT_THAT(notes_of(over), Contains(HasSubstr(told)));
    EXPECT_THAT(notes_of(open), Not(Contains(HasSubstr("may be wrong"))));  // they are rendered again
    start(folder.path());  // quarantine, and who rendered what, outlive the coordinator
  }
  grpc::ClientContext context;
  v1::TrustHostRequest request;
  request.set_host("liar");
  v1::TrustHostResponse response;
  ASSERT_TRUE(farm_->TrustHost(&context, request, &response).ok());
  EXPECT_THAT(notes_of(over), Not(Contains(HasSubstr("liar"))));
}

}  // namespace
}  // namespace tessera::server
