// Streams whose other end takes, or sends, nothing. Each of these ends because the coordinator ends it; a
// limit is the test's own timeout.
#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <thread>

#include "net/channel.h"
#include "service/coordinator_impl.h"
#include "service/rpc/open_streams.h"
#include "unit/server/coordinator_fixture.h"
#include "wire/digest.h"
#include "wire/limits.h"

namespace tessera::server {
namespace {

class OpenStreamsTest : public CoordinatorTest {
 protected:
  void start_on_a_port(std::chrono::milliseconds patience) {
    CoordinatorOptions options;
    options.listen = "127.0.0.1:0";
    options.stream_patience = patience;
    options.clock = &clock_;
    start(options);
    // Over a real socket, which holds little for a reader that takes nothing.
    grpc::ChannelArguments arguments = net::channel_arguments();
    arguments.SetInt(GRPC_ARG_HTTP2_STREAM_LOOKAHEAD_BYTES, 1024);
    arguments.SetInt(GRPC_ARG_HTTP2_BDP_PROBE, 0);
    const auto channel = grpc::CreateCustomChannel("127.0.0.1:" + std::to_string(coordinator_->bound_port()),
                                                   grpc::InsecureChannelCredentials(), arguments);
    farm_ = v1::FarmService::NewStub(channel);
    blobs_ = v1::BlobService::NewStub(channel);
  }

  void wait_until_one_is_cut() {
    while (coordinator_->impl().streams->cut_count() == 0) clock_.live_through(std::chrono::seconds{1});
  }

  std::string big_ = std::string(3 * wire::kBlobChunkBytes, 'b');
};

TEST_F(OpenStreamsTest, ADownloadThatNobodyReadsIsCutOff) {
  start_on_a_port(std::chrono::milliseconds{300});
  ASSERT_TRUE(upload(big_).ok());
  grpc::ClientContext context;
  v1::DownloadRequest request;
  request.mutable_blob()->set_digest(wire::sha256_hex(big_));
  const auto stream = blobs_->Download(&context, request);
  wait_until_one_is_cut();
  std::size_t got = 0;
  for (v1::DownloadResponse chunk; stream->Read(&chunk);) got += chunk.data().size();
  EXPECT_LT(got, big_.size());
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::CANCELLED);
}

TEST_F(OpenStreamsTest, AWatcherThatTakesNothingIsCutOff) {
  start_on_a_port(std::chrono::milliseconds{300});
  v1::JobSpec spec = job_spec();
  spec.mutable_farm()->set_name(std::string(4000, 'n'));  // comes with every status
  grpc::ClientContext context;
  v1::WatchJobRequest request;
  request.set_job_id(submit(spec));
  const auto stream = farm_->WatchJob(&context, request);
  wait_until_one_is_cut();
  for (v1::WatchJobResponse message; stream->Read(&message);) {
  }
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::CANCELLED);
}

TEST_F(OpenStreamsTest, AnUploadThatSendsNothingIsCutOffAndLeavesItsPlaceToOthers) {
  start_on_a_port(std::chrono::milliseconds{300});
  grpc::ClientContext context;
  v1::UploadResponse response;
  const auto stream = blobs_->Upload(&context, &response);
  v1::UploadRequest request;
  request.mutable_blob()->set_digest(wire::sha256_hex(big_));
  request.mutable_blob()->set_size_bytes(big_.size());
  request.set_data(big_.substr(0, wire::kBlobChunkBytes));
  ASSERT_TRUE(stream->Write(request));
  wait_until_one_is_cut();
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::CANCELLED);

  grpc::StatusCode code;
  // The reactor, too, has to know that it was cut off.
  do {
    code = upload(big_).error_code();
  } while (code == grpc::StatusCode::UNAVAILABLE);
  EXPECT_EQ(code, grpc::StatusCode::OK);
}

TEST_F(OpenStreamsTest, OneThatSaysNothingAtAllIsCutOffToo) {
  start_on_a_port(std::chrono::milliseconds{300});
  grpc::ClientContext context;
  v1::UploadResponse response;
  const auto stream = blobs_->Upload(&context, &response);
  wait_until_one_is_cut();
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::CANCELLED);
}

TEST_F(OpenStreamsTest, WhoeverTakesWhatComesIsNot) {
  start_on_a_port(std::chrono::minutes{1});
  ASSERT_TRUE(upload(big_).ok());
  grpc::ClientContext context;
  v1::DownloadRequest request;
  request.mutable_blob()->set_digest(wire::sha256_hex(big_));
  const auto stream = blobs_->Download(&context, request);
  std::string bytes;
  // Longer than the patience altogether, and less with any two messages.
  for (v1::DownloadResponse chunk; stream->Read(&chunk); clock_.live_through(std::chrono::seconds{25}))
    bytes += chunk.data();
  EXPECT_TRUE(stream->Finish().ok());
  EXPECT_EQ(bytes, big_);
  EXPECT_EQ(coordinator_->impl().streams->cut_count(), 0u);
}

}  // namespace
}  // namespace tessera::server
