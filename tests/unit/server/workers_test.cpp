// WorkService.
#include <gmock/gmock.h>

#include <future>

#include "unit/server/coordinator_fixture.h"
#include "unit/server/requests.h"
#include "wire/version.h"

namespace tessera::server {
namespace {

using testing::HasSubstr;

class WorkersTest : public CoordinatorTest {
 protected:
  void SetUp() override { start(); }

  grpc::Status try_register(const v1::RegisterRequest& request) {
    grpc::ClientContext context;
    v1::RegisterResponse response;
    return work_->Register(&context, request, &response);
  }

  v1::HeartbeatResponse heartbeat(const std::string& worker, const v1::LeaseResponse& leases) {
    v1::HeartbeatRequest request;
    request.set_worker_id(worker);
    for (const v1::Lease& lease : leases.leases()) *request.add_leases() = lease.token();
    grpc::ClientContext context;
    v1::HeartbeatResponse response;
    EXPECT_TRUE(work_->Heartbeat(&context, request, &response).ok());
    return response;
  }
};

TEST_F(WorkersTest, AMismatchIsRefusedByName) {
  const v1::RegisterRequest request = registration("render7");
  EXPECT_TRUE(try_register(request).ok());

  v1::RegisterRequest other = request;
  other.set_protocol(wire::kProtocolVersion + 1);
  EXPECT_EQ(try_register(other).error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_THAT(try_register(other).error_message(), HasSubstr("protocol"));
  other = request;
  other.set_build("0.0.0");
  EXPECT_EQ(try_register(other).error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_THAT(try_register(other).error_message(), HasSubstr("0.0.0"));
  other = request;
  other.set_isa("avx512");
  EXPECT_EQ(try_register(other).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  other = request;
  other.add_supported_isas(std::string(1000, 'x'));
  EXPECT_EQ(try_register(other).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  other = request;
  for (const std::uint32_t threads : {0u, 4097u, ~0u}) {
    other = request;
    other.set_threads(threads);
    EXPECT_EQ(try_register(other).error_code(), grpc::StatusCode::INVALID_ARGUMENT) << threads;
  }
}

TEST_F(WorkersTest, AResultCostsNoMoreThanItsLeaseLasted) {
  CoordinatorOptions options;
  options.clock = &clock_;
  start(std::move(options));
  const std::string id = submit(job_spec());
  const std::string worker = register_worker();  // two threads
  const v1::LeaseResponse leases = lease(worker, 4);
  ASSERT_EQ(leases.leases_size(), 4);
  clock_.advance(std::chrono::milliseconds{99});
  const auto cost_of = [](std::int64_t seconds) {
    v1::UnitStats stats;
    stats.mutable_cpu_time()->set_seconds(seconds);
    stats.mutable_wall_time()->set_seconds(seconds);
    (*stats.mutable_stage_ns())["shading"] = 1'000'000'000;
    return stats;
  };
  // Nothing that is believed for being less than a month, and what was never believed.
  const std::vector<std::int64_t> claims = {20 * 24 * 3600, 1, std::int64_t{1} << 50, -5};
  for (int i = 0; i < 4; ++i) {
    grpc::ClientContext context;
    v1::CompleteRequest request;
    request.set_worker_id(worker);
    *request.mutable_token() = leases.leases(i).token();
    request.set_payload(payload_for(leases.leases(i).unit()));
    *request.mutable_stats() = cost_of(claims[static_cast<std::size_t>(i)]);
    v1::CompleteResponse response;
    ASSERT_TRUE(work_->Complete(&context, request, &response).ok());
  }
  const v1::UnitStats total = job(id).stats();
  EXPECT_EQ(total.cpu_time().nanos(), 400'000'000) << "two units of 100 ms on two threads";
  EXPECT_EQ(total.wall_time().nanos(), 200'000'000);
  EXPECT_EQ(total.cpu_time().seconds() + total.wall_time().seconds(), 0);
  EXPECT_TRUE(total.stage_ns().empty());
}

TEST_F(WorkersTest, OfALargeFarmAreHeardOfLessOften) {
  CoordinatorOptions options;
  options.heartbeat_interval = std::chrono::milliseconds(1);
  options.lease_timeout = std::chrono::milliseconds(200'000);
  start(std::move(options));
  const std::string first = register_worker();
  const auto interval_ms = [&] { return heartbeat(first, {}).heartbeat_interval().nanos() / 1'000'000; };
  EXPECT_EQ(interval_ms(), 1);
  for (int i = 1; i < 100; ++i) register_worker();
  EXPECT_EQ(interval_ms(), 50);  // 100 workers, 2000 heartbeats a second
}

TEST_F(WorkersTest, ALeaseWaitsForWork) {
  const std::string worker = register_worker();
  EXPECT_EQ(lease(worker, 4).leases_size(), 0) << "without a wait, an empty answer comes at once";
  auto waiting = std::async([&] { return lease(worker, 3, std::chrono::seconds(20)); });
  const std::string id = submit(job_spec());
  const v1::LeaseResponse response = waiting.get();
  EXPECT_EQ(response.leases_size(), 3);
  ASSERT_TRUE(response.specs().contains(id));
  EXPECT_EQ(response.specs().at(id).farm().isa(), "avx2") << "the ISA that the job is bound to";
  EXPECT_EQ(response.specs().at(id).cut().tile_size(), 16u);
}

TEST_F(WorkersTest, KnownSpecsAreNotSentAgain) {
  const std::string id = submit(job_spec());
  v1::LeaseRequest request;
  request.set_worker_id(register_worker());
  request.set_max_units(1);
  request.add_known_job_ids(id);
  grpc::ClientContext context;
  v1::LeaseResponse response;
  ASSERT_TRUE(work_->Lease(&context, request, &response).ok());
  EXPECT_EQ(response.leases_size(), 1);
  EXPECT_TRUE(response.specs().empty());
}

TEST_F(WorkersTest, AResultIsAnsweredWithTheNextUnits) {
  const std::string id = submit(job_spec());
  const std::string worker = register_worker();
  v1::LeaseResponse held = lease(worker, 1);
  ASSERT_EQ(held.leases_size(), 1);
  const auto deliver = [&](const v1::Lease& lease, const std::string& payload, v1::CompleteResponse& response,
                           const v1::LeaseRequest& more) {
    v1::CompleteRequest request;
    request.set_worker_id(worker);
    *request.mutable_token() = lease.token();
    request.set_payload(payload);
    *request.mutable_more() = more;
    grpc::ClientContext context;
    return work_->Complete(&context, request, &response);
  };
  v1::LeaseRequest more;
  more.set_max_units(1);
  v1::CompleteResponse refused;
  EXPECT_EQ(deliver(held.leases(0), "no result", refused, more).error_code(),
            grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(refused.more().leases_size(), 0);

  v1::CompleteResponse first;
  ASSERT_TRUE(deliver(held.leases(0), payload_for(held.leases(0).unit()), first, more).ok());
  ASSERT_EQ(first.more().leases_size(), 1);
  EXPECT_NE(first.more().leases(0).unit().index(), held.leases(0).unit().index());
  EXPECT_EQ(first.more().specs().count(id), 1u);
  EXPECT_EQ(job(id).units_leased(), 1u);

  more.add_known_job_ids(id);
  v1::CompleteResponse second;
  const v1::Lease next = first.more().leases(0);
  ASSERT_TRUE(deliver(next, payload_for(next.unit()), second, more).ok());
  ASSERT_EQ(second.more().leases_size(), 1);
  EXPECT_TRUE(second.more().specs().empty());

  // Naming too much costs the units, not the result.
  for (int i = 0; i < 5000; ++i) more.add_known_job_ids("job");
  v1::CompleteResponse third;
  const v1::Lease last = second.more().leases(0);
  ASSERT_TRUE(deliver(last, payload_for(last.unit()), third, more).ok());
  EXPECT_EQ(third.more().leases_size(), 0);
  EXPECT_EQ(job(id).units_done(), 3u);
}

TEST_F(WorkersTest, ACallThatWaitsIsShort) {
  v1::LeaseRequest request;
  request.set_worker_id(register_worker());
  request.set_max_units(1);
  request.mutable_max_wait()->set_seconds(20);
  request.add_known_job_ids(std::string(2 << 20, 'x'));
  grpc::ClientContext context;
  v1::LeaseResponse response;
  EXPECT_EQ(work_->Lease(&context, request, &response).error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
}

TEST_F(WorkersTest, OnlyResultsOfTheUnitAreTaken) {
  submit(job_spec());
  const std::string worker = register_worker();
  const v1::LeaseResponse leases = lease(worker, 2);
  const v1::Lease& first = leases.leases(0);
  EXPECT_EQ(complete(worker, first, "").error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(complete(worker, first, payload_for(leases.leases(1).unit())).error_code(),
            grpc::StatusCode::INVALID_ARGUMENT);
  std::string damaged = payload_for(first.unit());
  damaged.back() = static_cast<char>(damaged.back() ^ 1);
  EXPECT_EQ(complete(worker, first, damaged).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  v1::Lease beyond = first;
  beyond.mutable_token()->set_unit_index(99);
  EXPECT_EQ(complete(worker, beyond, payload_for(first.unit())).error_code(),
            grpc::StatusCode::FAILED_PRECONDITION);

  EXPECT_TRUE(complete(worker, first, payload_for(first.unit())).ok());
  EXPECT_TRUE(complete(worker, first, payload_for(first.unit())).ok()) << "idempotent";
  EXPECT_EQ(complete(worker, first, payload_for(first.unit(), 1)).error_code(),
            grpc::StatusCode::ALREADY_EXISTS);
}

TEST_F(WorkersTest, HeartbeatsRevokeWhatWasCancelled) {
  const std::string id = submit(job_spec());
  const std::string worker = register_worker();
  const v1::LeaseResponse leases = lease(worker, 2);
  EXPECT_EQ(heartbeat(worker, leases).revoked_size(), 0);
  grpc::ClientContext context;
  v1::CancelJobRequest request;
  request.set_job_id(id);
  v1::CancelJobResponse response;
  ASSERT_TRUE(farm_->CancelJob(&context, request, &response).ok());
  EXPECT_EQ(heartbeat(worker, leases).revoked_size(), 2);
  EXPECT_EQ(complete(worker, leases.leases(0), payload_for(leases.leases(0).unit())).error_code(),
            grpc::StatusCode::FAILED_PRECONDITION);
}

TEST_F(WorkersTest, AResultBringsAHeartbeat) {
  CoordinatorOptions options;
  options.lease_timeout = std::chrono::seconds(6);
  options.clock = &clock_;
  start(std::move(options));
  const std::string worker = register_worker();
  const std::string id = submit(job_spec());
  const v1::LeaseResponse held = lease(worker, 4);
  ASSERT_EQ(held.leases_size(), 4);
  // Nothing else is heard of the worker for longer than leases live without it.
  for (int i = 0; i < 3; ++i) {
    clock_.live_through(std::chrono::milliseconds(2100));
    const v1::Lease& home = held.leases(i);
    v1::CompleteRequest request;
    request.set_worker_id(worker);
    *request.mutable_token() = home.token();
    request.set_payload(payload_for(home.unit()));
    *request.mutable_beat()->add_leases() = held.leases(3).token();
    if (i == 2) *request.mutable_beat()->add_leases() = held.leases(0).token();
    grpc::ClientContext context;
    v1::CompleteResponse response;
    ASSERT_TRUE(work_->Complete(&context, request, &response).ok());
    ASSERT_TRUE(response.has_beat());
    ASSERT_EQ(response.beat().revoked_size(), i == 2 ? 1 : 0) << "the unit that is done";
    EXPECT_EQ(response.beat().heartbeat_interval().seconds(), 1);
  }
  EXPECT_EQ(job(id).units_leased(), 1u) << "the fourth unit was not given up";
}

TEST_F(WorkersTest, AWorkerThatLeavesGivesItsLeasesBackAtOnce) {
  submit(job_spec());
  const std::string first = register_worker(), second = register_worker();
  EXPECT_EQ(lease(first, 4).leases_size(), 4);
  auto waiting = std::async([&] { return lease(second, 4, std::chrono::seconds(20)); });
  grpc::ClientContext context;
  v1::DeregisterRequest request;
  request.set_worker_id(first);
  v1::DeregisterResponse response;
  ASSERT_TRUE(work_->Deregister(&context, request, &response).ok());
  EXPECT_EQ(waiting.get().leases_size(), 4);
}

TEST_F(WorkersTest, StrangersAreToldToRegister) {
  submit(job_spec());
  const v1::LeaseResponse leases = lease(register_worker(), 1);
  const grpc::Status status = complete("stranger", leases.leases(0), payload_for(leases.leases(0).unit()));
  EXPECT_EQ(status.error_code(), grpc::StatusCode::NOT_FOUND);
  grpc::ClientContext context;
  v1::LeaseRequest request;
  request.set_worker_id("stranger");
  v1::LeaseResponse response;
  EXPECT_EQ(work_->Lease(&context, request, &response).error_code(), grpc::StatusCode::NOT_FOUND);
}

TEST_F(WorkersTest, AreListed) {
  submit(job_spec());
  const std::string worker = register_worker();
  lease(worker, 3);
  grpc::ClientContext context;
  v1::ListWorkersResponse response;
  ASSERT_TRUE(farm_->ListWorkers(&context, {}, &response).ok());
  ASSERT_EQ(response.workers_size(), 1);
  EXPECT_EQ(response.workers(0).worker_id(), worker);
  EXPECT_EQ(response.workers(0).leases(), 3u);
  EXPECT_EQ(response.workers(0).threads(), 2u);
}

}  // namespace
}  // namespace tessera::server
