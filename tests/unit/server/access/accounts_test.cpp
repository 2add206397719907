// Upper bounds of what one who was let in makes the coordinator hold.
#include "service/farm/accounts.h"

#include <google/protobuf/util/time_util.h>
#include <gtest/gtest.h>

#include <future>
#include <list>
#include <string>
#include <vector>

#include "unit/server/coordinator_fixture.h"
#include "unit/server/requests.h"
#include "wire/digest.h"

namespace tessera::server {
namespace {

using grpc::StatusCode;

TEST(AccountsOf, EachAreBoundedTogetherAndApart) {
  const auto accounts = Accounts::make({.registrations = 1, .calls = 2, .streams = 1, .bytes = 100});
  const auto first = accounts->take("a", {.calls = 1, .bytes = 60});
  ASSERT_TRUE(first.ok());
  EXPECT_TRUE(absl::IsResourceExhausted(accounts->take("a", {.calls = 1, .bytes = 41}).status()));
  EXPECT_EQ(accounts->held_by("a").calls, 1u) << "what is refused is not counted";
  EXPECT_TRUE(accounts->take("b", {.calls = 1, .bytes = 100}).ok());
  auto second = accounts->take("a", {.registrations = 1, .bytes = 40});
  ASSERT_TRUE(second.ok());
  EXPECT_EQ(accounts->held_by("a").bytes, 100u);
  second->reset();
  EXPECT_EQ(accounts->held_by("a").bytes, 60u);
  EXPECT_TRUE(accounts->take("a", {.registrations = 1}).ok());
}

TEST(AccountsOf, NobodyAreForgotten) {
  const auto accounts = Accounts::make();
  { const auto hold = accounts->take("a", {.streams = 1}); }
  EXPECT_EQ(accounts->holders(), 0u);
}

TEST(AccountsOf, CallersAreTheirCertificatesOrTheirAddress) {
  EXPECT_EQ(holder_of("alice", "ipv4:10.0.0.1:4711"), "alice");
  EXPECT_EQ(holder_of("", "ipv4:10.0.0.1:4711"), "ipv4:10.0.0.1");
  EXPECT_EQ(holder_of("", "ipv6:%5B::1%5D:4711"), "ipv6:%5B::1%5D");
}

class AccountTest : public CoordinatorTest {
 protected:
  void start_with(const Holding& of_each) {
    CoordinatorOptions options;
    options.of_each = of_each;
    start(std::move(options));
  }

  StatusCode register_code(const v1::RegisterRequest& request) {
    grpc::ClientContext context;
    v1::RegisterResponse response;
    const StatusCode code = work_->Register(&context, request, &response).error_code();
    last_worker_ = response.worker_id();
    return code;
  }

  StatusCode lease_code(const v1::LeaseRequest& request) {
    grpc::ClientContext context;
    v1::LeaseResponse response;
    return work_->Lease(&context, request, &response).error_code();
  }
  /// That waits for work.
  v1::LeaseRequest waiting_lease(const std::string& worker, int seconds) {
    v1::LeaseRequest request;
    request.set_worker_id(worker);
    request.set_max_units(1);
    request.mutable_max_wait()->set_seconds(seconds);
    return request;
  }

  std::string last_worker_;
};

TEST_F(AccountTest, RegistrationsAreBoundedAndComeBack) {
  start_with({.registrations = 3, .calls = 9, .streams = 9, .bytes = 1 << 20});
  for (int i = 0; i < 3; ++i) EXPECT_EQ(register_code(registration("one", "avx2")), StatusCode::OK);
  const std::string leaving = last_worker_;
  EXPECT_EQ(register_code(registration("one", "avx2")), StatusCode::RESOURCE_EXHAUSTED);
  grpc::ClientContext context;
  v1::DeregisterRequest request;
  request.set_worker_id(leaving);
  v1::DeregisterResponse response;
  ASSERT_TRUE(work_->Deregister(&context, request, &response).ok());
  EXPECT_EQ(register_code(registration("one", "avx2")), StatusCode::OK);
}

TEST_F(AccountTest, ARegistrationThatIsRefusedCountsForNothing) {
  start_with({.registrations = 1, .calls = 9, .streams = 9, .bytes = 1 << 20});
  v1::RegisterRequest other_build = registration("one", "avx2");
  other_build.set_build("another");
  for (int i = 0; i < 3; ++i) EXPECT_EQ(register_code(other_build), StatusCode::FAILED_PRECONDITION);
  EXPECT_EQ(register_code(registration("one", "avx2")), StatusCode::OK);
}

TEST_F(AccountTest, WaitingCallsAreBounded) {
  start_with({.registrations = 9, .calls = 2, .streams = 9, .bytes = 1 << 20});
  const std::string worker = register_worker();
  std::vector<std::future<StatusCode>> waiting;
  for (int i = 0; i < 2; ++i) {
    waiting.push_back(std::async(std::launch::async, [&] { return lease_code(waiting_lease(worker, 30)); }));
  }
  // Both have begun when a call that came after them is refused.
  while (lease_code(waiting_lease(worker, 0)) != StatusCode::RESOURCE_EXHAUSTED) {
  }
  submit(job_spec());
  for (auto& call : waiting) EXPECT_EQ(call.get(), StatusCode::OK);
  // A call is given back when its answer is on its way, which may be after it has come.
  StatusCode next = StatusCode::RESOURCE_EXHAUSTED;
  while (next == StatusCode::RESOURCE_EXHAUSTED) next = lease_code(waiting_lease(worker, 0));
  EXPECT_EQ(next, StatusCode::OK);
}

TEST_F(AccountTest, OpenStreamsAreBounded) {
  start_with({.registrations = 9, .calls = 9, .streams = 2, .bytes = 1 << 20});
  struct Open {
    grpc::ClientContext context;
    v1::UploadResponse response;
    std::unique_ptr<grpc::ClientWriter<v1::UploadRequest>> stream;
  };
  std::list<Open> open(2);
  int number = 0;
  for (Open& upload : open) {
    upload.stream = blobs_->Upload(&upload.context, &upload.response);
    v1::UploadRequest chunk;
    chunk.mutable_blob()->set_digest(wire::sha256_hex(std::to_string(++number)));
    chunk.mutable_blob()->set_size_bytes(10);
    ASSERT_TRUE(upload.stream->Write(chunk));
  }
  // Both have begun when a call that came after them is refused.
  while (upload("another").error_code() != StatusCode::RESOURCE_EXHAUSTED) {
  }
  for (Open& upload : open) upload.context.TryCancel();
  for (Open& upload : open) upload.stream->Finish();
  while (!upload("another").ok()) {
  }
}

TEST_F(AccountTest, NothingIsLongerThanItHasToBe) {
  start();
  v1::RegisterRequest tags = registration("one", "avx2");
  for (int i = 0; i < 64; ++i) tags.add_tags(std::string(250, 't'));
  EXPECT_EQ(register_code(tags), StatusCode::INVALID_ARGUMENT);
  v1::RegisterRequest isas = registration("one", "avx2");
  isas.add_supported_isas(std::string(200, 'i'));
  EXPECT_EQ(register_code(isas), StatusCode::INVALID_ARGUMENT);

  v1::LeaseRequest names = waiting_lease(register_worker(), 0);
  for (int i = 0; i < 200; ++i) names.add_loaded_scene_digests(std::string(5000, 'd'));
  EXPECT_EQ(lease_code(names), StatusCode::RESOURCE_EXHAUSTED);

  v1::JobSpec aovs = job_spec();
  for (int i = 0; i < 1'000'000; ++i) aovs.mutable_view()->add_aovs(v1::AOV_DEPTH);
  grpc::ClientContext context;
  v1::SubmitJobRequest request;
  request.set_request_id("request");
  *request.mutable_spec() = aovs;
  v1::SubmitJobResponse response;
  EXPECT_EQ(farm_->SubmitJob(&context, request, &response).error_code(), StatusCode::INVALID_ARGUMENT);
}

}  // namespace
}  // namespace tessera::server
