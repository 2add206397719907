// A coordinator within the test's process, and what clients and workers do with it.
#pragma once

#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "service/coordinator.h"
#include "tessera/v1/blob.grpc.pb.h"
#include "tessera/v1/farm.grpc.pb.h"
#include "tessera/v1/work.grpc.pb.h"
#include "unit/server/manual_clock.h"

namespace tessera::server {

/// Result of a unit, with values that depend on `seed`.
std::string payload_for(const v1::WorkUnit& unit, int seed = 0);

/// A seal with which the same results are audited each time, by the same workers. TESSERA_SEED=N in the
/// environment draws others.
std::shared_ptr<const LeaseSeal> seal_of_tests();

class CoordinatorTest : public testing::Test {
 protected:
  /// Stops the one that runs, and starts another; an empty path keeps everything in memory.
  void start(const std::filesystem::path& data_dir = {});
  void start(CoordinatorOptions options);
  void stop();

  grpc::Status upload(const std::string& bytes);
  /// A spec of 2 x 2 tiles and `ranges` sample ranges, whose scene was uploaded.
  v1::JobSpec job_spec(std::uint32_t ranges = 1);
  std::string submit(const v1::JobSpec& spec);
  v1::GetJobResponse get_job(const std::string& id);
  v1::JobStatus job(const std::string& id);
  /// Reads the whole stream; its status is OK unless told otherwise.
  std::vector<v1::WatchJobResponse> watch(const v1::WatchJobRequest& request,
                                          grpc::StatusCode code = grpc::StatusCode::OK);

  std::string register_worker(const std::string& isa = "avx2");
  v1::LeaseResponse lease(const std::string& worker, std::uint32_t units,
                          std::chrono::milliseconds wait = {});
  /// `took`: what the worker says that rendering took; 0: it does not say.
  grpc::Status complete(const std::string& worker, const v1::Lease& lease, const std::string& payload,
                        std::chrono::milliseconds took = {});
  grpc::Status fail(const std::string& worker, const v1::Lease& lease, const std::string& message,
                    const std::vector<std::string>& log = {});

  ManualClock clock_;  // the clock of coordinators that are given it
  std::unique_ptr<Coordinator> coordinator_;
  std::unique_ptr<v1::FarmService::Stub> farm_;
  std::unique_ptr<v1::WorkService::Stub> work_;
  std::unique_ptr<v1::BlobService::Stub> blobs_;
  int requests_ = 0;
};

}  // namespace tessera::server
