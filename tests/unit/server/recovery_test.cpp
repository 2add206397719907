// A coordinator that starts again on its data directory.
#include <gmock/gmock.h>

#include <set>

#include "absl/strings/str_cat.h"
#include "support/process/temp_dir.h"
#include "unit/server/coordinator_fixture.h"

namespace tessera::server {
namespace {

class RecoveryTest : public CoordinatorTest {
 protected:
  support::TempDir directory_;
};

TEST_F(RecoveryTest, AJobGoesOnWhereItWas) {
  start(directory_.path());
  const std::string id = submit(job_spec(2));
  const std::string worker = register_worker("avx512");
  const v1::LeaseResponse leases = lease(worker, 5);
  std::set<std::uint32_t> done;
  for (int i = 0; i < 3; ++i) {
    const v1::Lease& lease = leases.leases(i);
    ASSERT_TRUE(complete(worker, lease, payload_for(lease.unit())).ok());
    done.insert(lease.unit().index());
  }

  start(directory_.path());
  EXPECT_EQ(job(id).units_done(), 3u);
  EXPECT_EQ(job(id).isa(), "avx512") << "the ISA is remembered";
  EXPECT_EQ(job(id).stats().samples(), 300u);
  EXPECT_EQ(lease(register_worker("avx2"), 8).leases_size(), 0) << "bound to another ISA";
  const std::string again = register_worker("avx512");
  // Acknowledged before: the same bytes are welcome, others are a fault, in the new epoch too.
  EXPECT_TRUE(complete(again, leases.leases(0), payload_for(leases.leases(0).unit())).ok());
  EXPECT_EQ(complete(again, leases.leases(0), payload_for(leases.leases(0).unit(), 1)).error_code(),
            grpc::StatusCode::ALREADY_EXISTS);
  // Leased before, not completed: valid.
  EXPECT_TRUE(complete(again, leases.leases(3), payload_for(leases.leases(3).unit())).ok());
  done.insert(leases.leases(3).unit().index());
  const v1::LeaseResponse rest = lease(again, 100);
  EXPECT_EQ(rest.leases_size(), 4);
  for (const v1::Lease& lease : rest.leases()) {
    EXPECT_TRUE(done.insert(lease.unit().index()).second) << "asked for again";
    EXPECT_GT(lease.token().epoch(), leases.leases(0).token().epoch());
    ASSERT_TRUE(complete(again, lease, payload_for(lease.unit())).ok());
  }
  EXPECT_EQ(job(id).state(), v1::DONE);
}

TEST_F(RecoveryTest, AClientFetchesLater) {
  start(directory_.path());
  const std::string id = submit(job_spec());
  const std::string worker = register_worker();
  const v1::LeaseResponse leases = lease(worker, 4);
  for (const v1::Lease& lease : leases.leases())
    ASSERT_TRUE(complete(worker, lease, payload_for(lease.unit())).ok());

  start(directory_.path());
  const v1::JobStatus status = job(id);
  EXPECT_EQ(status.state(), v1::DONE);
  EXPECT_EQ(status.units_done(), 4u);
  EXPECT_EQ(status.stats().samples(), 400u);
  v1::WatchJobRequest request;
  request.set_job_id(id);
  const auto messages = watch(request);
  ASSERT_EQ(messages.back().results_size(), 4);
  for (const v1::UnitResult& result : messages.back().results())
    EXPECT_EQ(result.payload(), payload_for(result.unit()));
  // A worker whose last acknowledgement was lost is not told off.
  EXPECT_TRUE(complete(register_worker(), leases.leases(3), payload_for(leases.leases(3).unit())).ok());
  // The scene is still there.
  EXPECT_FALSE(submit(job_spec()).empty());
}

TEST_F(RecoveryTest, SubmissionsAndCancellationsAreRemembered) {
  start(directory_.path());
  const std::string first = submit(job_spec()), second = submit(job_spec());
  grpc::ClientContext context;
  v1::CancelJobRequest request;
  request.set_job_id(first);
  v1::CancelJobResponse response;
  ASSERT_TRUE(farm_->CancelJob(&context, request, &response).ok());

  start(directory_.path());
  EXPECT_EQ(job(first).state(), v1::CANCELLED);
  EXPECT_EQ(job(second).state(), v1::QUEUED);
  requests_ = 1;  // the second request once more, by a client that did not see the answer
  EXPECT_EQ(submit(job_spec()), second);
  const v1::LeaseResponse leases = lease(register_worker(), 100);
  for (const v1::Lease& lease : leases.leases()) EXPECT_EQ(lease.token().job_id(), second);
}

TEST_F(RecoveryTest, TwoCoordinatorsDoNotShareADirectoryOrAPort) {
  start(directory_.path());
  CoordinatorOptions options;
  options.data_dir = directory_.path();
  EXPECT_EQ(Coordinator::start(options).status().code(), absl::StatusCode::kFailedPrecondition);
  options.data_dir.clear();
  options.listen = "127.0.0.1:0";
  const auto listening = Coordinator::start(options);
  ASSERT_TRUE(listening.ok()) << listening.status();
  EXPECT_GT((*listening)->bound_port(), 0);
  options.listen = absl::StrCat("127.0.0.1:", (*listening)->bound_port());
  EXPECT_EQ(Coordinator::start(options).status().code(), absl::StatusCode::kUnavailable);
  options.listen = "0.0.0.0:0";
  EXPECT_EQ(Coordinator::start(options).status().code(), absl::StatusCode::kPermissionDenied);
  options.listen = "7070";
  EXPECT_EQ(Coordinator::start(options).status().code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace tessera::server
