// BlobService.
#include <gmock/gmock.h>

#include <filesystem>

#include "service/rpc/blob_upload.h"
#include "store/data_dir.h"
#include "support/process/temp_dir.h"
#include "unit/server/coordinator_fixture.h"
#include "wire/digest.h"
#include "wire/limits.h"

namespace tessera::server {
namespace {

class BlobsTest : public CoordinatorTest {
 protected:
  void SetUp() override {
    start();
    for (std::size_t i = 0; i < bytes_.size(); ++i) bytes_[i] = static_cast<char>(i * 7 + i / 1000);
    blob_.set_digest(wire::sha256_hex(bytes_));
    blob_.set_size_bytes(bytes_.size());
  }

  grpc::Status upload_chunks(std::uint64_t offset, const std::vector<std::string>& chunks) {
    grpc::ClientContext context;
    v1::UploadResponse response;
    const auto stream = blobs_->Upload(&context, &response);
    v1::UploadRequest request;
    *request.mutable_blob() = blob_;
    request.set_offset(offset);
    for (const std::string& chunk : chunks) {
      request.set_data(chunk);
      if (!stream->Write(request)) break;
    }
    stream->WritesDone();
    return stream->Finish();
  }

  v1::QueryUploadResponse query() {
    grpc::ClientContext context;
    v1::QueryUploadRequest request;
    *request.mutable_blob() = blob_;
    v1::QueryUploadResponse response;
    EXPECT_TRUE(blobs_->QueryUpload(&context, request, &response).ok());
    return response;
  }

  grpc::Status download(std::uint64_t offset, std::string& bytes) {
    grpc::ClientContext context;
    v1::DownloadRequest request;
    *request.mutable_blob() = blob_;
    request.set_offset(offset);
    const auto stream = blobs_->Download(&context, request);
    for (v1::DownloadResponse chunk; stream->Read(&chunk);) {
      EXPECT_LE(chunk.data().size(), wire::kBlobChunkBytes);
      bytes += chunk.data();
    }
    return stream->Finish();
  }

  std::string bytes_ = std::string(2'500'000, '\0');
  v1::BlobRef blob_;
};

TEST_F(BlobsTest, GoUpAndDown) {
  std::string down;
  EXPECT_EQ(download(0, down).error_code(), grpc::StatusCode::NOT_FOUND);
  ASSERT_TRUE(upload(bytes_).ok());
  EXPECT_TRUE(query().complete());
  EXPECT_TRUE(download(0, down).ok());
  EXPECT_EQ(down, bytes_);
  down.clear();
  EXPECT_TRUE(download(2'000'000, down).ok());
  EXPECT_EQ(down, bytes_.substr(2'000'000));
  EXPECT_TRUE(upload(bytes_).ok()) << "a second time does no harm";
}

TEST_F(BlobsTest, OnlyMissingOnesAreNamed) {
  ASSERT_TRUE(upload("one").ok());
  v1::FindMissingRequest request;
  request.add_blobs()->set_digest(wire::sha256_hex("one"));
  *request.add_blobs() = blob_;
  grpc::ClientContext context;
  v1::FindMissingResponse response;
  ASSERT_TRUE(blobs_->FindMissing(&context, request, &response).ok());
  ASSERT_EQ(response.missing_size(), 1);
  EXPECT_EQ(response.missing(0).digest(), blob_.digest());

  request.add_blobs()->set_digest("../../etc/passwd");
  grpc::ClientContext second;
  EXPECT_EQ(blobs_->FindMissing(&second, request, &response).error_code(),
            grpc::StatusCode::INVALID_ARGUMENT);
}

TEST_F(BlobsTest, AnUploadGoesOnWhereItBroke) {
  EXPECT_EQ(upload_chunks(0, {bytes_.substr(0, 1'000'000)}).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(query().stored_bytes(), 1'000'000u);
  EXPECT_FALSE(query().complete());
  EXPECT_EQ(upload_chunks(5, {"x"}).error_code(), grpc::StatusCode::OUT_OF_RANGE);
  EXPECT_TRUE(upload_chunks(1'000'000, {bytes_.substr(1'000'000, 1'000'000), bytes_.substr(2'000'000)}).ok());
  std::string down;
  EXPECT_TRUE(download(0, down).ok());
  EXPECT_EQ(down, bytes_);
}

TEST_F(BlobsTest, WhatIsNotTheBlobIsRefused) {
  std::string wrong = bytes_.substr(0, 1'000'000);
  wrong[5] ^= 1;
  EXPECT_EQ(
      upload_chunks(0, {wrong, bytes_.substr(1'000'000, 1'000'000), bytes_.substr(2'000'000)}).error_code(),
      grpc::StatusCode::DATA_LOSS);
  EXPECT_EQ(query().stored_bytes(), 0u);
  EXPECT_EQ(upload_chunks(0, {bytes_}).error_code(), grpc::StatusCode::INVALID_ARGUMENT)
      << "a chunk above the cap";
  EXPECT_EQ(upload_chunks(0, {}).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  blob_.set_size_bytes(3);
  EXPECT_EQ(upload_chunks(0, {"four"}).error_code(), grpc::StatusCode::INVALID_ARGUMENT)
      << "longer than announced";
  blob_.set_size_bytes(std::uint64_t{1} << 50);
  EXPECT_EQ(upload_chunks(0, {"x"}).error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  blob_.set_digest("../x");
  EXPECT_EQ(upload_chunks(0, {"x"}).error_code(), grpc::StatusCode::INVALID_ARGUMENT);
}

TEST(BlobUpload, StopsWhereTheRoomEndsAndGoesOnWhenThereIsMore) {
  const support::TempDir directory;
  ASSERT_TRUE(DataDir::open(directory.path()).ok());
  DiskSpace space{.free_bytes = 100, .total_bytes = 1000};
  const auto blobs =
      make_file_blob_store(directory.path(), {.bytes = 50, .space = [&](const auto&) { return space; }});
  const std::string bytes(40, 'b');
  v1::UploadRequest first;
  first.mutable_blob()->set_digest(wire::sha256_hex(bytes));
  first.mutable_blob()->set_size_bytes(60);
  EXPECT_TRUE(absl::IsResourceExhausted(BlobUpload{*blobs}.take(first)))
      << "there never would be room for it";
  EXPECT_TRUE(std::filesystem::is_empty(directory.path() / "partial")) << "so nothing was made";

  first.mutable_blob()->set_size_bytes(bytes.size());
  first.set_data(bytes.substr(0, 20));
  {
    BlobUpload upload{*blobs};
    EXPECT_TRUE(upload.take(first).ok());
    space.free_bytes = 60;  // somebody else wrote
    v1::UploadRequest second;
    second.set_data(bytes.substr(20));
    EXPECT_TRUE(absl::IsResourceExhausted(upload.take(second)));
    EXPECT_TRUE(absl::IsResourceExhausted(upload.finish()));
  }
  EXPECT_EQ(blobs->query(first.blob().digest()).stored_bytes, 20u);

  space.free_bytes = 100;
  first.set_offset(20);
  first.set_data(bytes.substr(20));
  {
    BlobUpload upload{*blobs};
    EXPECT_TRUE(upload.take(first).ok());
    EXPECT_TRUE(upload.finish().ok());
  }
  // A blob that is there takes no room.
  space.free_bytes = 0;
  first.set_offset(0);
  BlobUpload again{*blobs};
  EXPECT_TRUE(again.take(first).ok());
  EXPECT_FALSE(again.wants_more());
}

TEST_F(BlobsTest, ADiskThatIsFullOfThemStillTakesResults) {
  const support::TempDir directory;
  start(directory.path());
  const v1::JobSpec spec = job_spec();
  const std::string id = submit(spec);
  CoordinatorOptions full;
  full.data_dir = directory.path();
  full.keep_free_bytes = std::uint64_t{1} << 60;  // more than any disk has
  start(full);
  const grpc::Status refused = upload(bytes_);
  EXPECT_EQ(refused.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_THAT(refused.error_message(), testing::HasSubstr("try again"));
  EXPECT_TRUE(upload("a scene").ok()) << "it is there";

  grpc::ClientContext context;
  v1::SubmitJobRequest request;
  request.set_request_id("one more");
  *request.mutable_spec() = spec;
  v1::SubmitJobResponse response;
  EXPECT_EQ(farm_->SubmitJob(&context, request, &response).error_code(),
            grpc::StatusCode::RESOURCE_EXHAUSTED);
  const std::string worker = register_worker();
  while (job(id).state() != v1::DONE) {
    const v1::LeaseResponse leases = lease(worker, 4);
    for (const v1::Lease& lease : leases.leases())
      ASSERT_TRUE(complete(worker, lease, payload_for(lease.unit())).ok());
  }
  v1::WatchJobRequest watched;
  watched.set_job_id(id);
  int results = 0;
  for (const v1::WatchJobResponse& message : watch(watched)) results += message.results_size();
  EXPECT_EQ(results, 4);
}

}  // namespace
}  // namespace tessera::server
