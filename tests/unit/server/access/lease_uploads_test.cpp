// Workers upload only what a lease calls for; and what becomes of that.
#include "service/farm/lease_uploads.h"

#include <gmock/gmock.h>

#include <filesystem>

#include "support/phased_job.h"
#include "unit/server/access/tls_fixture.h"
#include "unit/server/coordinator_fixture.h"

namespace tessera::server {
namespace {

using testing::HasSubstr;

v1::BlobRef ref_of(const std::string& bytes) {
  v1::BlobRef ref;
  ref.set_digest(wire::sha256_hex(bytes));
  ref.set_size_bytes(bytes.size());
  return ref;
}

grpc::Status upload_for(v1::BlobService::Stub& blobs, const std::string& bytes, const std::string& worker,
                        const v1::LeaseToken* token) {
  v1::UploadRequest chunk;
  *chunk.mutable_blob() = ref_of(bytes);
  chunk.set_data(bytes);
  chunk.set_worker_id(worker);
  if (token != nullptr) *chunk.mutable_token() = *token;
  grpc::ClientContext context;
  v1::UploadResponse response;
  const auto stream = blobs.Upload(&context, &response);
  stream->Write(chunk);
  stream->WritesDone();
  return stream->Finish();
}

/// Workers and clients with certificates.
class UnitUploads : public TlsTest {
 protected:
  v1::LeaseResponse lease(const std::string& worker) {
    grpc::ClientContext context;
    v1::LeaseRequest request;
    request.set_worker_id(worker);
    request.set_max_units(100);
    v1::LeaseResponse response;
    EXPECT_TRUE(work().Lease(&context, request, &response).ok());
    return response;
  }
  grpc::StatusCode complete(const std::string& worker, const v1::Lease& lease, const std::string& blob) {
    grpc::ClientContext context;
    v1::CompleteRequest request;
    request.set_worker_id(worker);
    *request.mutable_token() = lease.token();
    request.set_payload(ref_of(blob).SerializeAsString());
    v1::CompleteResponse response;
    return work().Complete(&context, request, &response).error_code();
  }
  grpc::StatusCode upload(const std::string& bytes, const std::string& worker,
                          const v1::LeaseToken* token = nullptr) {
    const auto blobs = v1::BlobService::NewStub(channel_of("worker"));
    return upload_for(*blobs, bytes, worker, token).error_code();
  }
  v1::WorkService::Stub& work() {
    if (work_ == nullptr) work_ = v1::WorkService::NewStub(channel_of("worker"));
    return *work_;
  }
  bool is_stored(const std::string& bytes) const {
    const std::string digest = wire::sha256_hex(bytes);
    const std::filesystem::path data = folder_.path() / "data";
    return std::filesystem::exists(data / "blobs" / digest.substr(0, 2) / digest) ||
           std::filesystem::exists(data / "partial" / digest);
  }

  std::unique_ptr<v1::WorkService::Stub> work_;
};

TEST_F(UnitUploads, AreThoseThatALeaseCallsFor) {
  using enum grpc::StatusCode;
  const std::string loot = "what nobody asked for";
  EXPECT_EQ(upload(loot, ""), NOT_FOUND);
  std::string worker;
  ASSERT_EQ(register_worker(channel_of("worker"), worker), OK);
  EXPECT_EQ(upload(loot, worker), NOT_FOUND) << "there is no such job";

  std::string picture;
  ASSERT_EQ(submit(channel_of("client-alice"), "alice", picture), OK);
  const v1::LeaseResponse tiles = lease(worker);
  ASSERT_EQ(tiles.leases_size(), 1);
  EXPECT_EQ(upload(loot, worker, &tiles.leases(0).token()), FAILED_PRECONDITION) << "a tile has no blob";

  v1::SubmitJobRequest phased;
  phased.set_request_id("phased");
  *phased.mutable_spec() = square_spec("a scene", 16);
  test::add_test_phases(*phased.mutable_spec(), {2, 1});
  grpc::ClientContext context;
  v1::SubmitJobResponse response;
  ASSERT_TRUE(
      v1::FarmService::NewStub(channel_of("client-alice"))->SubmitJob(&context, phased, &response).ok());
  const v1::LeaseResponse parts = lease(worker);
  ASSERT_EQ(parts.leases_size(), 2);
  const v1::Lease &first = parts.leases(0), &second = parts.leases(1);
  v1::LeaseToken forged = first.token();
  forged.set_attempt(99);
  EXPECT_EQ(upload(loot, worker, &forged), FAILED_PRECONDITION);
  EXPECT_EQ(upload("part 0", worker, &first.token()), OK);
  EXPECT_EQ(upload(loot, worker, &first.token()), INVALID_ARGUMENT) << "a lease brings one blob";
  EXPECT_EQ(complete(worker, first, "part 0"), OK);
  EXPECT_EQ(upload(loot, worker, &first.token()), FAILED_PRECONDITION) << "it is done";
  EXPECT_EQ(upload("part 1", worker, &second.token()), OK);
  EXPECT_EQ(complete(worker, second, "part 1"), OK);
  EXPECT_TRUE(is_stored("part 0") && is_stored("part 1"));
  EXPECT_FALSE(is_stored(loot));
}

class UnclaimedUnitUploads : public CoordinatorTest {
 protected:
  std::filesystem::path file_of(const std::string& bytes) const {
    const std::string digest = wire::sha256_hex(bytes);
    return directory_.path() / "blobs" / digest.substr(0, 2) / digest;
  }
  static void make_old(const std::filesystem::path& file) {
    std::filesystem::last_write_time(file,
                                     std::filesystem::file_time_type::clock::now() - std::chrono::hours{1});
  }

  support::TempDir directory_;
};

TEST_F(UnclaimedUnitUploads, AreDeletedAndOthersAreNot) {
  CoordinatorOptions options;
  options.data_dir = directory_.path();
  options.clock = &clock_;
  start(options);
  v1::JobSpec spec = job_spec();
  test::add_test_phases(spec, {3, 1});
  submit(spec);
  const std::string worker = register_worker();
  const v1::LeaseResponse parts = lease(worker, 100);
  ASSERT_EQ(parts.leases_size(), 3);
  const auto bring = [&](const std::string& bytes, const v1::Lease& lease) {
    EXPECT_TRUE(upload_for(*blobs_, bytes, worker, &lease.token()).ok()) << bytes;
  };
  bring("a result", parts.leases(0));
  ASSERT_TRUE(complete(worker, parts.leases(0), ref_of("a result").SerializeAsString()).ok());
  bring("nobody's", parts.leases(1));
  bring("asked for", parts.leases(2));
  ASSERT_TRUE(upload("a client's").ok());
  for (const char* bytes : {"a result", "nobody's", "a client's"}) make_old(file_of(bytes));
  clock_.live_through(LeaseUploads::kKept - std::chrono::seconds{1});
  EXPECT_TRUE(std::filesystem::exists(file_of("nobody's"))) << "it is not time yet";
  // Deleted by a thread of its own.
  while (std::filesystem::exists(file_of("nobody's"))) clock_.live_through(std::chrono::seconds{16});
  stop();
  for (const char* bytes : {"a result", "asked for", "a client's", "a scene"})
    EXPECT_TRUE(std::filesystem::exists(file_of(bytes))) << bytes;
}

TEST(LeaseUploads, AreBoundedByLeaseAndIdentity) {
  using enum absl::StatusCode;
  LeaseUploads uploads;
  const LeaseUploads::TimePoint start{};
  const auto begin = [&](std::uint32_t unit, const std::string& bytes, std::uint64_t size,
                         const std::string& identity = "ada") {
    v1::LeaseToken token;
    token.set_job_id("job");
    token.set_unit_index(unit);
    v1::BlobRef ref = ref_of(bytes);
    ref.set_size_bytes(size);
    return uploads.begin(token, ref, identity, start).code();
  };
  EXPECT_EQ(begin(0, "a", LeaseUploads::kMostBlobBytes + 1), kInvalidArgument);
  std::uint32_t unit = 0;
  for (; (unit + 1) * LeaseUploads::kMostBlobBytes <= LeaseUploads::kMostIdentityBytes; ++unit)
    EXPECT_EQ(begin(unit, std::to_string(unit), LeaseUploads::kMostBlobBytes), kOk);
  EXPECT_EQ(begin(unit, "one more", 1), kResourceExhausted);
  EXPECT_EQ(begin(unit, "one more", 1, "bob"), kOk) << "each identity has a bound of its own";
  EXPECT_EQ(begin(0, "0", LeaseUploads::kMostBlobBytes), kOk) << "it goes on";
  EXPECT_EQ(begin(0, "another", 1, "bob"), kInvalidArgument) << "the lease has brought one";
  uploads.claim(wire::sha256_hex("0"));
  EXPECT_EQ(begin(unit + 1, "one more still", 1), kOk);
  EXPECT_EQ(begin(unit + 2, "empty", 0, "eve"), kOk);
  EXPECT_EQ(begin(unit + 3, "empty, too", 0, "eve"), kOk);
  EXPECT_EQ(uploads.held_by("bob"), 1u);
  EXPECT_EQ(uploads.take_old(start).size(), 0u);
  EXPECT_EQ(uploads.take_old(start + LeaseUploads::kKept).size(), unit - 1 + 4);
  for (const char* identity : {"ada", "bob", "eve"}) EXPECT_EQ(uploads.held_by(identity), 0u);
}

}  // namespace
}  // namespace tessera::server
