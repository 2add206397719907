#include "store/blobs/blob_store.h"

#include <gtest/gtest.h>

#include <fstream>
#include <optional>
#include <random>

#include "store/data_dir.h"
#include "support/process/temp_dir.h"
#include "wire/digest.h"

namespace tessera::server {
namespace {

class BlobStoreTest : public testing::TestWithParam<bool> {
 protected:
  BlobStoreTest() {
    if (GetParam()) {
      EXPECT_TRUE(DataDir::open(directory_.path()).ok());
      store_ = make_file_blob_store(directory_.path());
    } else {
      store_ = make_memory_blob_store();
    }
    std::mt19937 random(5);
    for (char& c : bytes_) c = static_cast<char>(random());
    digest_ = wire::sha256_hex(bytes_);
  }

  std::string read_all() {
    const auto reader = store_->read(digest_);
    EXPECT_TRUE(reader.ok()) << reader.status();
    return reader.ok() ? (*reader)->read(0, (*reader)->size()).value() : "";
  }

  support::TempDir directory_;
  std::unique_ptr<BlobStore> store_;
  std::string bytes_ = std::string(3'000'000, '\0');
  std::string digest_;
};

TEST_P(BlobStoreTest, StoresWholeBlobs) {
  EXPECT_EQ(store_->read(digest_).status().code(), absl::StatusCode::kNotFound);
  auto writer = store_->write(digest_, 0).value();
  ASSERT_TRUE(writer->append(std::string_view(bytes_).substr(0, 1000)).ok());
  EXPECT_EQ(store_->read(digest_).status().code(), absl::StatusCode::kNotFound) << "not before it is whole";
  ASSERT_TRUE(writer->append(std::string_view(bytes_).substr(1000)).ok());
  ASSERT_TRUE(writer->finish().ok());
  EXPECT_TRUE(store_->query(digest_).complete);
  EXPECT_EQ(read_all(), bytes_);
  const auto reader = store_->read(digest_).value();
  EXPECT_EQ(reader->read(bytes_.size() - 3, 10).value(), bytes_.substr(bytes_.size() - 3));
  EXPECT_EQ(reader->read(bytes_.size() + 3, 10).value(), "");
  writer.reset();
  EXPECT_EQ(store_->write(digest_, 0).status().code(), absl::StatusCode::kAlreadyExists);
}

TEST_P(BlobStoreTest, AnUploadGoesOnWhereItBroke) {
  {
    auto writer = store_->write(digest_, 0).value();
    ASSERT_TRUE(writer->append(std::string_view(bytes_).substr(0, 2'000'000)).ok());
  }
  const UploadState state = store_->query(digest_);
  EXPECT_FALSE(state.complete);
  EXPECT_EQ(state.stored_bytes, 2'000'000u);
  EXPECT_EQ(store_->write(digest_, 1'999'999).status().code(), absl::StatusCode::kOutOfRange);
  auto writer = store_->write(digest_, 2'000'000).value();
  ASSERT_TRUE(writer->append(std::string_view(bytes_).substr(2'000'000)).ok());
  ASSERT_TRUE(writer->finish().ok());
  EXPECT_EQ(read_all(), bytes_);
}

TEST_P(BlobStoreTest, WrongBytesAreDroppedAtTheEnd) {
  {
    auto writer = store_->write(digest_, 0).value();
    ASSERT_TRUE(writer->append("something else").ok());
    EXPECT_EQ(writer->finish().code(), absl::StatusCode::kDataLoss);
  }
  EXPECT_EQ(store_->query(digest_).stored_bytes, 0u);
  auto writer = store_->write(digest_, 0).value();
  ASSERT_TRUE(writer->append(bytes_).ok());
  EXPECT_TRUE(writer->finish().ok());
}

TEST_P(BlobStoreTest, OneWriterABlob) {
  auto writer = store_->write(digest_, 0).value();
  EXPECT_EQ(store_->write(digest_, 0).status().code(), absl::StatusCode::kUnavailable);
  writer.reset();
  EXPECT_TRUE(store_->write(digest_, 0).ok());
}

TEST_P(BlobStoreTest, AnEmptyBlobIsABlob) {
  const std::string digest = wire::sha256_hex("");
  auto writer = store_->write(digest, 0).value();
  ASSERT_TRUE(writer->finish().ok());
  EXPECT_TRUE(store_->query(digest).complete);
  EXPECT_EQ(store_->read(digest).value()->size(), 0u);
}

INSTANTIATE_TEST_SUITE_P(Stores, BlobStoreTest, testing::Bool(),
                         [](const auto& store) { return store.param ? "File" : "Memory"; });

TEST(FileBlobStore, OutlivesTheProcessAndNoticesTornParts) {
  const support::TempDir directory;
  ASSERT_TRUE(DataDir::open(directory.path()).ok());
  const std::string bytes(100'000, 'b');
  const std::string digest = wire::sha256_hex(bytes);
  {
    auto writer = make_file_blob_store(directory.path())->write(digest, 0).value();
    ASSERT_TRUE(writer->append(std::string_view(bytes).substr(0, 50'000)).ok());
  }
  // A power cut leaves this: the length is there, the contents are not.
  std::filesystem::resize_file(directory.path() / "partial" / digest, 0);
  std::filesystem::resize_file(directory.path() / "partial" / digest, 50'000);

  const auto store = make_file_blob_store(directory.path());
  EXPECT_EQ(store->query(digest).stored_bytes, 50'000u);
  {
    auto writer = store->write(digest, 50'000).value();
    ASSERT_TRUE(writer->append(std::string_view(bytes).substr(50'000)).ok());
    EXPECT_EQ(writer->finish().code(), absl::StatusCode::kDataLoss);
  }
  auto writer = store->write(digest, 0).value();
  ASSERT_TRUE(writer->append(bytes).ok());
  ASSERT_TRUE(writer->finish().ok());
  EXPECT_TRUE(make_file_blob_store(directory.path())->query(digest).complete);
}

std::size_t open_descriptors() {
  return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator{"/proc/self/fd"},
                                                std::filesystem::directory_iterator{}));
}

TEST(FileBlobStore, UploadsThatWaitAndReadersOfOneBlobTakeNoDescriptors) {
  const support::TempDir directory;
  ASSERT_TRUE(DataDir::open(directory.path()).ok());
  const auto store = make_file_blob_store(directory.path());
  const std::size_t before = open_descriptors();
  std::vector<std::unique_ptr<BlobWriter>> writers;
  for (int i = 0; i < 1200; ++i) {
    writers.push_back(store->write(wire::sha256_hex(std::to_string(i)), 0).value());
    ASSERT_TRUE(writers.back()->append(std::to_string(i)).ok());
  }
  EXPECT_EQ(open_descriptors(), before);
  for (const auto& writer : writers) ASSERT_TRUE(writer->finish().ok());

  std::vector<std::unique_ptr<BlobReader>> readers;
  for (int i = 0; i < 1200; ++i) readers.push_back(store->read(wire::sha256_hex("7")).value());
  EXPECT_EQ(open_descriptors(), before + 1);
  EXPECT_EQ(readers.back()->read(0, 10).value(), "7");
  // There is a bound to different ones, until somebody is done.
  absl::Status status;
  for (int i = 0; i < 1200 && status.ok(); ++i) {
    auto reader = store->read(wire::sha256_hex(std::to_string(i)));
    status = reader.status();
    if (reader.ok()) readers.push_back(*std::move(reader));
  }
  EXPECT_TRUE(absl::IsResourceExhausted(status)) << status;
  EXPECT_LT(open_descriptors(), before + 200);
  readers.clear();
  EXPECT_TRUE(store->read(wire::sha256_hex("1199")).ok());
}

TEST(FileBlobStore, ABlobThatIsUploadedAgainIsReadAnew) {
  const support::TempDir directory;
  ASSERT_TRUE(DataDir::open(directory.path()).ok());
  const auto store = make_file_blob_store(directory.path());
  const std::string digest = wire::sha256_hex("bytes");
  const auto put = [&] {
    const auto writer = store->write(digest, 0).value();
    return writer->append("bytes").ok() && writer->finish().ok();
  };
  ASSERT_TRUE(put());
  const auto old = store->read(digest).value();
  std::ofstream(directory.path() / "blobs" / digest.substr(0, 2) / digest) << "wrong";
  EXPECT_TRUE(absl::IsNotFound(drop_if_damaged(*store, digest)));
  ASSERT_TRUE(put());
  EXPECT_EQ(store->read(digest).value()->read(0, 10).value(), "bytes");
  EXPECT_EQ(old->read(0, 10).value(), "wrong");
}

TEST(FileBlobStore, LeavesRoomForOthers) {
  const support::TempDir directory;
  DiskSpace space{.free_bytes = 60'000, .total_bytes = 1'000'000, .free_files = 100, .total_files = 1000};
  const auto store_that_keeps = [&](std::optional<std::uint64_t> bytes) {
    return make_file_blob_store(directory.path(),
                                {.bytes = bytes, .space = [&](const auto&) { return space; }});
  };
  const auto usual = store_that_keeps({});  // a twentieth: 50,000 bytes, and 50 files
  EXPECT_TRUE(usual->check_room(10'000).ok());
  const absl::Status full = usual->check_room(10'001);
  EXPECT_TRUE(absl::IsResourceExhausted(full));
  EXPECT_NE(std::string(full.message()).find("--keep-free"), std::string::npos) << full;
  EXPECT_TRUE(store_that_keeps(59'000)->check_room(1'000).ok());
  EXPECT_FALSE(store_that_keeps(59'000)->check_room(1'001).ok());

  space.free_files = 49;
  EXPECT_TRUE(absl::IsResourceExhausted(usual->check_room(0)));
  space = {.free_bytes = 10, .total_bytes = 1'000'000};
  EXPECT_TRUE(absl::IsResourceExhausted(usual->check_room(0)));
  EXPECT_TRUE(store_that_keeps(0)->check_room(1'000'000).ok()) << "somebody wants no reserve";
  // Less than a twentieth of a large disk is kept, and where there is no limit to files, none is made up.
  space = {.free_bytes = DiskReserve::kMostBytes, .total_bytes = std::uint64_t{1} << 50};
  EXPECT_TRUE(usual->check_room(0).ok());
  EXPECT_FALSE(usual->check_room(1).ok());
}

TEST(FileBlobStore, KnowsItsDisk) {
  const support::TempDir directory;
  const absl::StatusOr<DiskSpace> space = disk_space(directory.path());
  ASSERT_TRUE(space.ok()) << space.status();
  EXPECT_GT(space->total_bytes, 0u);
  EXPECT_LE(space->free_bytes, space->total_bytes);
  EXPECT_FALSE(disk_space(directory.path() / "nowhere").ok());
}

TEST(DataDir, BelongsToOneAtATime) {
  const support::TempDir directory;
  {
    const auto first = DataDir::open(directory.path());
    ASSERT_TRUE(first.ok());
    EXPECT_EQ(DataDir::open(directory.path()).status().code(), absl::StatusCode::kFailedPrecondition);
  }
  EXPECT_TRUE(DataDir::open(directory.path()).ok());
}

TEST(DataDir, SaysWhatItCannotMake) {
  const support::TempDir directory;
  std::ofstream(directory.path() / "file") << "x";
  const auto opened = DataDir::open(directory.path() / "file" / "state");
  EXPECT_FALSE(opened.ok());
  EXPECT_NE(std::string(opened.status().message()).find("state"), std::string::npos);
}

}  // namespace
}  // namespace tessera::server
