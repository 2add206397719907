// A coordinator that speaks TLS, with the certificates of a whole farm.
#pragma once

#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>

#include "net/channel.h"
#include "service/coordinator.h"
#include "support/patience.h"
#include "support/process/temp_dir.h"
#include "tessera/v1/blob.grpc.pb.h"
#include "tessera/v1/farm.grpc.pb.h"
#include "tessera/v1/work.grpc.pb.h"
#include "tls/authority.h"
#include "unit/server/coordinator_fixture.h"
#include "unit/server/requests.h"
#include "wire/digest.h"

namespace tessera::server {

class TlsTest : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(write_farm_certificates(farm_certificates(), {}, {"alice", "bob"}).ok());
    start();
  }

  /// Another coordinator, on the same data.
  void start(bool share_jobs = false) {
    coordinator_.reset();
    CoordinatorOptions options;
    options.share_jobs = share_jobs;
    options.listen = "127.0.0.1:0";
    options.data_dir = folder_.path() / "data";
    options.certificates = farm_certificates() / "server";
    options.certificate_interval = std::chrono::seconds{1};
    options.seal = seal_of_tests();
    auto started = Coordinator::start(options);
    ASSERT_TRUE(started.ok()) << started.status();
    coordinator_ = *std::move(started);
  }

  std::filesystem::path farm_certificates() const { return folder_.path() / "farm"; }

  std::string address() const { return "127.0.0.1:" + std::to_string(coordinator_->bound_port()); }

  std::shared_ptr<grpc::Channel> channel(const std::filesystem::path& certificates) const {
    auto made = net::make_channel(address(), {.certificates = certificates.string()});
    EXPECT_TRUE(made.ok()) << made.status();
    return made.ok() ? *made : nullptr;
  }
  std::shared_ptr<grpc::Channel> channel_of(const std::string& program) const {
    return channel(farm_certificates() / program);
  }

  static grpc::Status list(const std::shared_ptr<grpc::Channel>& channel, v1::ListJobsResponse& jobs) {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + support::kPatience);
    return v1::FarmService::NewStub(channel)->ListJobs(&context, {}, &jobs);
  }
  static grpc::StatusCode list_code(const std::shared_ptr<grpc::Channel>& channel) {
    v1::ListJobsResponse jobs;
    return list(channel, jobs).error_code();
  }

  static grpc::StatusCode register_code(const std::shared_ptr<grpc::Channel>& channel) {
    std::string worker;
    return register_worker(channel, worker);
  }
  static grpc::StatusCode register_worker(const std::shared_ptr<grpc::Channel>& channel,
                                          std::string& worker) {
    grpc::ClientContext context;
    v1::RegisterResponse response;
    const grpc::Status status =
        v1::WorkService::NewStub(channel)->Register(&context, registration("render7"), &response);
    worker = response.worker_id();
    return status.error_code();
  }

  /// Submits a job of a scene that is one blob; `id` is its own, or that of the one to continue.
  static grpc::StatusCode submit(const std::shared_ptr<grpc::Channel>& channel, const std::string& user,
                                 std::string& id, std::uint32_t side = 16) {
    const std::string scene = "a scene";
    {
      grpc::ClientContext context;
      v1::UploadResponse response;
      const auto stream = v1::BlobService::NewStub(channel)->Upload(&context, &response);
      v1::UploadRequest chunk;
      chunk.mutable_blob()->set_digest(wire::sha256_hex(scene));
      chunk.mutable_blob()->set_size_bytes(scene.size());
      chunk.set_data(scene);
      stream->Write(chunk);
      stream->WritesDone();
      EXPECT_TRUE(stream->Finish().ok());
    }
    v1::SubmitJobRequest request;
    request.set_request_id("request" + id);
    request.set_continued(id);
    *request.mutable_spec() = square_spec(scene, side);
    request.mutable_spec()->mutable_farm()->set_user(user);
    grpc::ClientContext context;
    v1::SubmitJobResponse response;
    const grpc::Status status = v1::FarmService::NewStub(channel)->SubmitJob(&context, request, &response);
    id = response.job_id();
    return status.error_code();
  }

  support::TempDir folder_;
  std::unique_ptr<Coordinator> coordinator_;
};

}  // namespace tessera::server
