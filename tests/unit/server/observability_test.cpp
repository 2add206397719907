// Metrics and health of a coordinator.
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <string>

#include "service/in_process.h"
#include "support/process/http_get.h"
#include "unit/server/coordinator_fixture.h"

namespace tessera::server {
namespace {

class Observability : public CoordinatorTest {
 protected:
  /// The value of a series; -1 when it is not there.
  double metric(const std::string& series) const {
    const std::string text = support::http_get(coordinator_->metrics_port(), "/metrics");
    const std::size_t at = text.find("\n" + series + " ");
    return at == std::string::npos ? -1 : std::stod(text.substr(at + series.size() + 2));
  }
};

TEST_F(Observability, MetricsFollowAJob) {
  CoordinatorOptions options;
  options.metrics = "127.0.0.1:0";
  start(options);
  ASSERT_GT(coordinator_->metrics_port(), 0);
  EXPECT_EQ(metric("tessera_workers{state=\"idle\"}"), 0);

  const std::string job = submit(job_spec());  // four units
  const std::string worker = register_worker();
  EXPECT_EQ(metric("tessera_jobs{state=\"QUEUED\"}"), 1);
  EXPECT_EQ(metric("tessera_units{state=\"waiting\"}"), 4);
  EXPECT_GT(metric("tessera_uploaded_bytes_total"), 0);

  const v1::LeaseResponse leases = lease(worker, 3);
  ASSERT_EQ(leases.leases_size(), 3);
  EXPECT_EQ(metric("tessera_units{state=\"leased\"}"), 3);
  EXPECT_EQ(metric("tessera_units{state=\"waiting\"}"), 1);
  EXPECT_EQ(metric("tessera_leases_total"), 3);
  EXPECT_EQ(metric("tessera_workers{state=\"working\"}"), 1);

  const std::string payload = payload_for(leases.leases(0).unit());
  ASSERT_TRUE(complete(worker, leases.leases(0), payload).ok());
  ASSERT_TRUE(complete(worker, leases.leases(0), payload).ok());  // repeated because an answer was lost
  EXPECT_FALSE(complete(worker, leases.leases(1), "no result").ok());
  EXPECT_EQ(metric("tessera_units{state=\"done\"}"), 1);
  EXPECT_EQ(metric("tessera_unit_seconds_count"), 1);
  EXPECT_EQ(metric("tessera_repeated_results_total"), 1);
  EXPECT_EQ(metric("tessera_refused_results_total"), 1);
  EXPECT_EQ(metric("tessera_result_bytes_total"), static_cast<double>(payload.size()));
  EXPECT_GE(metric("tessera_scheduler_seconds_count{call=\"lease\"}"), 1);
  EXPECT_GE(metric("tessera_commit_seconds_count"), 1);
}

TEST_F(Observability, MetricsThatCannotBeServedAreAnError) {
  CoordinatorOptions options;
  options.metrics = "127.0.0.1:0";
  start(options);
  CoordinatorOptions same;
  same.metrics = "127.0.0.1:" + std::to_string(coordinator_->metrics_port());
  EXPECT_TRUE(absl::IsUnavailable(Coordinator::start(same).status()));
}

/// Answer of grpc.health.v1.Health/Check, in bytes.
std::string ask_for_health(const std::shared_ptr<grpc::Channel>& channel) {
  grpc::GenericStub stub{channel};
  grpc::ClientContext context;
  grpc::CompletionQueue queue;
  const grpc::ByteBuffer empty_request{nullptr, 0};
  const auto call = stub.PrepareUnaryCall(&context, "/grpc.health.v1.Health/Check", empty_request, &queue);
  call->StartCall();
  grpc::ByteBuffer answer;
  grpc::Status status;
  call->Finish(&answer, &status, nullptr);
  void* tag = nullptr;
  bool ok = false;
  EXPECT_TRUE(queue.Next(&tag, &ok));
  EXPECT_TRUE(status.ok()) << status.error_message();
  grpc::Slice bytes;
  EXPECT_TRUE(answer.DumpToSingleSlice(&bytes).ok());
  queue.Shutdown();
  while (queue.Next(&tag, &ok)) {
  }
  return {reinterpret_cast<const char*>(bytes.begin()), bytes.size()};
}

constexpr char kServing[] = "\x08\x01";  // status: SERVING

TEST_F(Observability, HealthIsServing) {
  start();
  EXPECT_EQ(ask_for_health(in_process_channel(*coordinator_)), kServing);
}

TEST_F(Observability, HealthHasAPortOfItsOwnForProbesWithoutCertificates) {
  CoordinatorOptions options;
  options.health = "127.0.0.1:0";
  start(options);
  const std::string address = absl::StrCat("127.0.0.1:", coordinator_->health_port());
  const auto channel = grpc::CreateChannel(address, grpc::InsecureChannelCredentials());
  EXPECT_EQ(ask_for_health(channel), kServing);

  // Nothing else is served there.
  const auto farm = v1::FarmService::NewStub(channel);
  grpc::ClientContext context;
  v1::ListJobsResponse jobs;
  EXPECT_EQ(farm->ListJobs(&context, {}, &jobs).error_code(), grpc::StatusCode::UNIMPLEMENTED);

  CoordinatorOptions same;
  same.health = address;
  EXPECT_TRUE(absl::IsUnavailable(Coordinator::start(same).status()));
}

}  // namespace
}  // namespace tessera::server
