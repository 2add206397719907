#include "unit/server/coordinator_fixture.h"

#include <google/protobuf/util/time_util.h>

#include "absl/strings/str_cat.h"
#include "service/farm/lease_seal.h"
#include "service/in_process.h"
#include "support/long_form.h"
#include "unit/server/requests.h"
#include "wire/aov_channels.h"
#include "wire/digest.h"
#include "wire/limits.h"
#include "wire/tile_result.h"

namespace tessera::server {

using google::protobuf::util::TimeUtil;

std::string payload_for(const v1::WorkUnit& unit, int seed) {
  const v1::PixelRect& pixels = unit.tile().pixels();
  const v1::SampleRange& samples = unit.tile().samples();
  wire::TileResult result;
  result.x0 = pixels.x0(), result.y0 = pixels.y0(), result.x1 = pixels.x1(), result.y1 = pixels.y1();
  result.sample_begin = samples.begin(), result.sample_end = samples.end();
  result.channels = wire::channels_for_aovs({});
  result.counts.assign(result.pixel_count(), samples.end() - samples.begin());
  result.values.assign(result.pixel_count() * result.channels.size(), static_cast<float>(seed) + 0.5f);
  return wire::encode_tile_result(result);
}

std::shared_ptr<const LeaseSeal> seal_of_tests() {
  const std::string seed = absl::StrCat("seed ", test::how_often("TESSERA_SEED", 1, 2));
  return LeaseSeal::with_key(wire::sha256_hex(seed).substr(0, LeaseSeal::kKeyBytes));
}

void CoordinatorTest::start(const std::filesystem::path& data_dir) {
  CoordinatorOptions options;
  options.data_dir = data_dir;
  start(std::move(options));
}

void CoordinatorTest::start(CoordinatorOptions options) {
  stop();
  if (options.seal == nullptr) options.seal = seal_of_tests();
  auto started = Coordinator::start(std::move(options));
  ASSERT_TRUE(started.ok()) << started.status();
  coordinator_ = *std::move(started);
  const auto channel = in_process_channel(*coordinator_);
  farm_ = v1::FarmService::NewStub(channel);
  work_ = v1::WorkService::NewStub(channel);
  blobs_ = v1::BlobService::NewStub(channel);
}

void CoordinatorTest::stop() { coordinator_.reset(); }

grpc::Status CoordinatorTest::upload(const std::string& bytes) {
  grpc::ClientContext context;
  v1::UploadResponse response;
  const auto stream = blobs_->Upload(&context, &response);
  v1::UploadRequest chunk;
  chunk.mutable_blob()->set_digest(wire::sha256_hex(bytes));
  chunk.mutable_blob()->set_size_bytes(bytes.size());
  for (std::size_t at = 0; at == 0 || at < bytes.size(); at += wire::kBlobChunkBytes) {
    chunk.set_data(bytes.substr(at, wire::kBlobChunkBytes));
    if (!stream->Write(chunk)) break;
    chunk.clear_blob();
  }
  stream->WritesDone();
  return stream->Finish();
}

v1::JobSpec CoordinatorTest::job_spec(std::uint32_t ranges) {
  const std::string scene = "a scene";
  EXPECT_TRUE(upload(scene).ok());
  v1::JobSpec spec = square_spec(scene, 32, ranges);
  spec.mutable_farm()->set_name("test");
  return spec;
}

std::string CoordinatorTest::submit(const v1::JobSpec& spec) {
  grpc::ClientContext context;
  v1::SubmitJobRequest request;
  request.set_request_id("request " + std::to_string(++requests_));
  *request.mutable_spec() = spec;
  v1::SubmitJobResponse response;
  const grpc::Status status = farm_->SubmitJob(&context, request, &response);
  EXPECT_TRUE(status.ok()) << status.error_message();
  return response.job_id();
}

v1::GetJobResponse CoordinatorTest::get_job(const std::string& id) {
  grpc::ClientContext context;
  v1::GetJobRequest request;
  request.set_job_id(id);
  v1::GetJobResponse response;
  EXPECT_TRUE(farm_->GetJob(&context, request, &response).ok());
  return response;
}

v1::JobStatus CoordinatorTest::job(const std::string& id) { return get_job(id).status(); }

std::vector<v1::WatchJobResponse> CoordinatorTest::watch(const v1::WatchJobRequest& request,
                                                         grpc::StatusCode code) {
  grpc::ClientContext context;
  const auto stream = farm_->WatchJob(&context, request);
  std::vector<v1::WatchJobResponse> messages;
  for (v1::WatchJobResponse message; stream->Read(&message);) messages.push_back(message);
  const grpc::Status status = stream->Finish();
  EXPECT_EQ(status.error_code(), code) << status.error_message();
  return messages;
}

std::string CoordinatorTest::register_worker(const std::string& isa) {
  grpc::ClientContext context;
  const v1::RegisterRequest request = registration("test worker", isa);
  v1::RegisterResponse response;
  const grpc::Status status = work_->Register(&context, request, &response);
  EXPECT_TRUE(status.ok()) << status.error_message();
  return response.worker_id();
}

v1::LeaseResponse CoordinatorTest::lease(const std::string& worker, std::uint32_t units,
                                         std::chrono::milliseconds wait) {
  grpc::ClientContext context;
  v1::LeaseRequest request;
  request.set_worker_id(worker);
  request.set_max_units(units);
  *request.mutable_max_wait() = TimeUtil::MillisecondsToDuration(wait.count());
  v1::LeaseResponse response;
  const grpc::Status status = work_->Lease(&context, request, &response);
  EXPECT_TRUE(status.ok()) << status.error_message();
  return response;
}

grpc::Status CoordinatorTest::complete(const std::string& worker, const v1::Lease& lease,
                                       const std::string& payload, std::chrono::milliseconds took) {
  grpc::ClientContext context;
  v1::CompleteRequest request;
  request.set_worker_id(worker);
  *request.mutable_token() = lease.token();
  request.set_payload(payload);
  request.mutable_stats()->set_samples(100);
  request.mutable_stats()->mutable_cpu_time()->set_nanos(700'000);
  *request.mutable_stats()->mutable_wall_time() = TimeUtil::MillisecondsToDuration(took.count());
  v1::CompleteResponse response;
  return work_->Complete(&context, request, &response);
}

grpc::Status CoordinatorTest::fail(const std::string& worker, const v1::Lease& lease,
                                   const std::string& message, const std::vector<std::string>& log) {
  grpc::ClientContext context;
  v1::FailRequest request;
  request.set_worker_id(worker);
  *request.mutable_token() = lease.token();
  request.set_message(message);
  for (const std::string& line : log) request.add_log(line);
  v1::FailResponse response;
  return work_->Fail(&context, request, &response);
}

}  // namespace tessera::server
