// Bits that flip, and files that are cut, under a coordinator that runs.
#include <gmock/gmock.h>

#include <fstream>
#include <map>
#include <thread>

#include "support/process/temp_dir.h"
#include "unit/server/coordinator_fixture.h"
#include "wire/digest.h"

namespace tessera::server {
namespace {

void flip_a_bit(const std::filesystem::path& path, std::uint64_t at) {
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekg(static_cast<std::streamoff>(at));
  const int byte = file.get();
  file.seekp(static_cast<std::streamoff>(at)).put(static_cast<char>(byte ^ (1 << at % 8)));
  ASSERT_TRUE(file.good());
}

class DamageTest : public CoordinatorTest {
 protected:
  std::filesystem::path results(const std::string& id) const { return directory_.path() / "results" / id; }

  /// Renders all that is to be had.
  void render(const std::string& worker) {
    const v1::LeaseResponse leases = lease(worker, 4);
    for (const v1::Lease& lease : leases.leases()) {
      ASSERT_TRUE(complete(worker, lease, payload_for(lease.unit())).ok());
      ++rendered_;
    }
  }

  std::string finished_job() {
    const std::string id = submit(job_spec());
    render(register_worker());
    EXPECT_EQ(job(id).state(), v1::DONE);
    rendered_ = 0;
    return id;
  }

  /// Watches the job, with a worker at hand, and checks each result that comes.
  void expect_all_results(const std::string& id) {
    const std::string worker = register_worker();
    std::vector<v1::WatchJobResponse> messages;
    std::jthread watcher([&](std::stop_token) {
      v1::WatchJobRequest request;
      request.set_job_id(id);
      messages = watch(request);
      over_ = true;
    });
    while (!over_) render(worker);
    watcher.join();
    over_ = false;
    std::map<std::uint32_t, std::string> payloads;
    for (const v1::WatchJobResponse& message : messages) {
      for (const v1::UnitResult& result : message.results()) {
        EXPECT_EQ(result.payload(), payload_for(result.unit())) << "of unit " << result.unit().index();
        payloads[result.unit().index()] = result.payload();
      }
    }
    EXPECT_EQ(payloads.size(), 4u);
    EXPECT_EQ(job(id).state(), v1::DONE);
  }

  support::TempDir directory_;
  std::atomic<bool> over_ = false;
  int rendered_ = 0;
};

TEST_F(DamageTest, AFlippedBitInAResultIsNoticedAndTheUnitDoneAgain) {
  start(directory_.path());
  const std::string id = finished_job();
  v1::WorkUnit unit;
  const std::uint64_t size = std::filesystem::file_size(results(id)) / 4;
  // The result that was done again is the last in the file: it is damaged next. The rest of the bytes is for
  // TileResult.EveryFlippedByteIsNoticedOrMeansNothing.
  for (std::uint64_t byte = 0; byte < size; byte += 7) {
    flip_a_bit(results(id), std::filesystem::file_size(results(id)) - 1 - byte);
    expect_all_results(id);
  }
  EXPECT_GE(rendered_, static_cast<int>(size / 7));
  EXPECT_THAT(job(id).notes(), testing::Contains(testing::HasSubstr("is done again: result ")));
}

TEST_F(DamageTest, AlsoInAJobThatWasOverBeforeTheCoordinatorStarted) {
  start(directory_.path());
  const std::string id = finished_job();
  stop();
  flip_a_bit(results(id), 30);
  start(directory_.path());
  expect_all_results(id);
  EXPECT_EQ(rendered_, 1);
  start(directory_.path());
  expect_all_results(id);
  EXPECT_EQ(rendered_, 1) << "it is whole now";
}

TEST_F(DamageTest, AlsoInAJobThatTheSchedulerHasForgotten) {
  CoordinatorOptions options;
  options.data_dir = directory_.path();
  options.late_results = std::chrono::milliseconds(0);
  options.clock = &clock_;
  start(std::move(options));
  const std::string id = submit(job_spec());
  const std::string worker = register_worker();
  const v1::LeaseResponse leases = lease(worker, 4);
  for (const v1::Lease& lease : leases.leases())
    ASSERT_TRUE(complete(worker, lease, payload_for(lease.unit())).ok());
  // Another result is refused as long as the scheduler knows the job.
  while (!complete(worker, leases.leases(0), payload_for(leases.leases(0).unit(), /*seed=*/1)).ok()) {
    clock_.live_through(std::chrono::seconds{1});
  }
  flip_a_bit(results(id), 30);
  expect_all_results(id);
  EXPECT_EQ(rendered_, 1);
}

TEST_F(DamageTest, ResultsThatWereCutOffAreRenderedAgain) {
  start(directory_.path());
  const std::string id = submit(job_spec());
  const std::string worker = register_worker();
  const v1::LeaseResponse leases = lease(worker, 3);
  for (const v1::Lease& lease : leases.leases())
    ASSERT_TRUE(complete(worker, lease, payload_for(lease.unit())).ok());
  stop();
  std::filesystem::resize_file(results(id), std::filesystem::file_size(results(id)) / 2);
  start(directory_.path());
  EXPECT_EQ(job(id).units_done(), 1u) << "the first of three is whole";
  expect_all_results(id);
  EXPECT_EQ(rendered_, 3);

  stop();
  std::filesystem::remove(results(id));
  start(directory_.path());
  expect_all_results(id);
  EXPECT_EQ(rendered_, 7);
}

TEST_F(DamageTest, AJobTakesOverWhatIsWholeOfAnother) {
  start(directory_.path());
  const std::string id = finished_job();
  flip_a_bit(results(id), 30);
  const std::string next = submit(job_spec());
  expect_all_results(next);
  EXPECT_EQ(rendered_, 1);
}

TEST_F(DamageTest, ADamagedBlobIsDroppedWhenSomebodyDoubtsIt) {
  start(directory_.path());
  const std::string bytes = "a blob of some bytes, of which each is damaged in turn",
                    digest = wire::sha256_hex(bytes);
  const std::filesystem::path path = directory_.path() / "blobs" / digest.substr(0, 2) / digest;
  const auto download = [&](std::string& received) {
    v1::DownloadRequest request;
    request.mutable_blob()->set_digest(digest);
    request.set_doubted(true);
    grpc::ClientContext context;
    const auto reader = blobs_->Download(&context, request);
    v1::DownloadResponse response;
    while (reader->Read(&response)) received += response.data();
    return reader->Finish();
  };
  for (std::uint64_t byte = 0; byte < bytes.size(); ++byte) {
    ASSERT_TRUE(upload(bytes).ok());
    std::string received;
    ASSERT_TRUE(download(received).ok());
    EXPECT_EQ(received, bytes);
    flip_a_bit(path, byte);
    received.clear();
    const grpc::Status status = download(received);
    EXPECT_EQ(status.error_code(), grpc::StatusCode::NOT_FOUND);
    EXPECT_THAT(status.error_message(), testing::HasSubstr("submit the scene again"));
    EXPECT_EQ(received, "");
  }
}

}  // namespace
}  // namespace tessera::server
