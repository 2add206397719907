// Hosts of a job, as its status shows them: who was slow, and who is not to be trusted.
#include <gmock/gmock.h>
#include <google/protobuf/util/time_util.h>
#include <gtest/gtest.h>

#include "service/job/host_shares.h"
#include "support/process/temp_dir.h"
#include "unit/server/coordinator_fixture.h"
#include "unit/server/requests.h"

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
  /// The worker's lease lasts as long as it says that its unit took.
  grpc::StatusCode bring(const std::string& worker, const v1::Lease& lease, int seed,
                         std::chrono::milliseconds wall_time) {
    clock_.advance(wall_time);
    grpc::ClientContext context;
    v1::CompleteRequest request;
    request.set_worker_id(worker);
    *request.mutable_token() = lease.token();
    request.set_payload(payload_for(lease.unit(), seed));
    *request.mutable_stats()->mutable_wall_time() =
        google::protobuf::util::TimeUtil::MillisecondsToDuration(wall_time.count());
    v1::CompleteResponse response;
    return work_->Complete(&context, request, &response).error_code();
  }
  std::vector<std::string> notes_of(const std::string& id) {
    const v1::JobStatus status = job(id);
    return {status.notes().begin(), status.notes().end()};
  }
};

TEST_F(Hosts, SlowOnesAreNamed) {
  const support::TempDir folder;
  // A result a unit, so that there are enough of them.
  const auto start_again = [&] {
    CoordinatorOptions options;
    options.data_dir = folder.path();
    options.longest_run = std::chrono::milliseconds{0};
    options.clock = &clock_;
    start(std::move(options));
  };
  start_again();
  const std::string id = submit(job_spec(/*ranges=*/256));  // 1024 units
  const std::vector<std::string> workers = {register_host("usual"), register_host("as usual"),
                                            register_host("slow")};
  for (int round = 0; round < 200; ++round) {
    for (const std::string& worker : workers) {
      const v1::LeaseResponse held = lease(worker, 1);
      // Once the scheduler knows it as slow, it may get none.
      if (held.leases().empty() && worker == workers[2]) continue;
      ASSERT_EQ(held.leases_size(), 1);
      ASSERT_EQ(bring(worker, held.leases(0), 0, std::chrono::milliseconds(worker == workers[2] ? 50 : 10)),
                grpc::StatusCode::OK);
    }
  }
  for (int round = 0; round < 2; ++round) {
    const v1::GetJobResponse response = get_job(id);
    ASSERT_EQ(response.slow_hosts_size(), 1);
    EXPECT_EQ(response.slow_hosts(0).host(), "slow");
    EXPECT_GE(response.slow_hosts(0).slowness(), HostShares::kSlow);
    EXPECT_GT(response.slow_hosts(0).units(), 0u);
    start_again();  // it is known to the next coordinator too
  }
}

TEST_F(Hosts, AFinishedJobTellsOfResultsByALiar) {
  const support::TempDir folder;
  start(folder.path());
  const std::string liar = register_host("liar"), honest = register_host("honest"),
                    third = register_host("third");
  const std::string over = submit(job_spec());
  const v1::LeaseResponse leases = lease(liar, 16);
  ASSERT_GT(leases.leases_size(), 0);
  for (const v1::Lease& lease : leases.leases())
    ASSERT_EQ(bring(liar, lease, 0, std::chrono::milliseconds{1}), grpc::StatusCode::OK);
  while (job(over).state() != v1::DONE) {
    const v1::LeaseResponse rest = lease(honest, 16);
    for (const v1::Lease& lease : rest.leases())
      ASSERT_EQ(bring(honest, lease, 0, std::chrono::milliseconds{1}), grpc::StatusCode::OK);
  }
  EXPECT_THAT(notes_of(over), Not(Contains(HasSubstr("liar"))));

  v1::JobSpec spec = job_spec();
  spec.mutable_view()->set_seed(2);
  const std::string open = submit(spec);
  // All three hold a lease of one unit: each coordinator gives out what the one before had given to another.
  std::vector<v1::Lease> disputed;
  for (const char* host : {"liar", "honest", "third"}) {
    start(folder.path());
    const v1::LeaseResponse granted = lease(register_host(host), 1);
    ASSERT_EQ(granted.leases_size(), 1);
    disputed.push_back(granted.leases(0));
  }
  const std::string again = register_host("liar");
  ASSERT_EQ(bring(again, disputed[0], 666, std::chrono::milliseconds{1}), grpc::StatusCode::OK);
  EXPECT_EQ(bring(register_host("honest"), disputed[1], 0, std::chrono::milliseconds{1}),
            grpc::StatusCode::ALREADY_EXISTS);
  EXPECT_EQ(bring(register_host("third"), disputed[2], 0, std::chrono::milliseconds{1}),
            grpc::StatusCode::ALREADY_EXISTS);
  const std::string told = std::to_string(leases.leases_size()) + " units are of host liar";
  for (int round = 0; round < 2; ++round) {
    EXPECT_THAT(notes_of(over), Contains(HasSubstr(told)));
    EXPECT_THAT(notes_of(open), Not(Contains(HasSubstr("may be wrong"))));  // its units are rendered again
    start(folder.path());  // quarantine, and who rendered what, outlive the coordinator
  }
  grpc::ClientContext context;
  v1::TrustHostRequest request;
  request.set_host("lair");
  v1::TrustHostResponse response;
  const grpc::Status unknown = farm_->TrustHost(&context, request, &response);
  EXPECT_EQ(unknown.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_THAT(unknown.error_message(), HasSubstr("did you mean 'liar'?"));
  grpc::ClientContext second;
  request.set_host("liar");
  ASSERT_TRUE(farm_->TrustHost(&second, request, &response).ok());
  EXPECT_THAT(notes_of(over), Not(Contains(HasSubstr("liar"))));
}

}  // namespace
}  // namespace tessera::server
