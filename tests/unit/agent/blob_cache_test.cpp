#include "agent/stores/blob_cache.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <thread>

#include "support/process/temp_dir.h"
#include "wire/digest.h"

namespace tessera::agent {
namespace {

namespace fs = std::filesystem;

class BlobCacheTest : public ::testing::Test {
 protected:
  std::unique_ptr<BlobCache> open(std::uint64_t cap_bytes = 1 << 20) {
    auto cache = BlobCache::open(base::machine_clock(), dir_.path(), cap_bytes);
    EXPECT_TRUE(cache.ok()) << cache.status();
    return *std::move(cache);
  }

  /// Delivers `bytes` from the offset on, and counts.
  BlobCache::Fetch fetch_of(std::string bytes) {
    return [this, bytes](std::uint64_t offset, const BlobCache::Sink& sink) {
      ++fetches_;
      return sink(std::string_view{bytes}.substr(offset));
    };
  }

  support::TempDir dir_;
  int fetches_ = 0;
};

TEST_F(BlobCacheTest, FetchesOnceAndMaps) {
  const std::string digest = wire::sha256_hex("hello");
  {
    const auto cache = open();
    const auto bytes = cache->get(digest, fetch_of("hello"));
    ASSERT_TRUE(bytes.ok()) << bytes.status();
    EXPECT_EQ(bytes->bytes, "hello");
  }
  const auto bytes = open()->get(digest, fetch_of("hello"));
  ASSERT_TRUE(bytes.ok());
  EXPECT_EQ(bytes->bytes, "hello");
  EXPECT_EQ(fetches_, 1);
}

TEST_F(BlobCacheTest, HoldsAnEmptyBlob) {
  const auto cache = open();
  const auto bytes = cache->get(wire::sha256_hex(""), fetch_of(""));
  ASSERT_TRUE(bytes.ok()) << bytes.status();
  EXPECT_TRUE(bytes->bytes.empty());
}

TEST_F(BlobCacheTest, GoesOnWhereAFetchBrokeOff) {
  const std::string all(10'000, 'a');
  const std::string digest = wire::sha256_hex(all);
  const auto cache = open();
  const auto broken = cache->get(digest, [&](std::uint64_t offset, const BlobCache::Sink& sink) {
    EXPECT_EQ(offset, 0U);
    EXPECT_TRUE(sink(std::string_view{all}.substr(0, 6'000)).ok());
    return absl::UnavailableError("gone");
  });
  EXPECT_EQ(broken.status().code(), absl::StatusCode::kUnavailable);
  EXPECT_FALSE(cache->find(digest)->has_value()) << "a part must not be seen as the blob";
  const auto whole = cache->get(digest, [&](std::uint64_t offset, const BlobCache::Sink& sink) {
    EXPECT_EQ(offset, 6'000U);
    return sink(std::string_view{all}.substr(offset));
  });
  ASSERT_TRUE(whole.ok()) << whole.status();
  EXPECT_EQ(whole->bytes, all);
}

TEST_F(BlobCacheTest, RefusesBytesWithAnotherDigestAndStartsAnew) {
  const std::string digest = wire::sha256_hex("right");
  const auto cache = open();
  EXPECT_EQ(cache->get(digest, fetch_of("wrong")).status().code(), absl::StatusCode::kDataLoss);
  EXPECT_FALSE(cache->find(digest)->has_value());
  const auto bytes = cache->get(digest, fetch_of("right"));
  ASSERT_TRUE(bytes.ok()) << bytes.status();
  EXPECT_EQ(bytes->bytes, "right");
}

TEST_F(BlobCacheTest, AFlippedBitAnywhereAndACutAnywhereAreNoticed) {
  const std::string bytes = "not more than some bytes, of which each is damaged in turn";
  const std::string digest = wire::sha256_hex(bytes);
  const fs::path path = dir_.path() / digest.substr(0, 2) / digest;
  ASSERT_TRUE(open()->get(digest, fetch_of(bytes)).ok());
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    {
      std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
      file.seekp(static_cast<std::streamoff>(at)).put(static_cast<char>(bytes[at] ^ (1 << at % 8)));
    }
    const auto flipped = open()->get(digest, fetch_of(bytes));
    ASSERT_TRUE(flipped.ok()) << flipped.status();
    EXPECT_EQ(flipped->bytes, bytes);
    fs::resize_file(path, at);
    const auto cut = open()->get(digest, fetch_of(bytes));
    ASSERT_TRUE(cut.ok()) << cut.status();
    EXPECT_EQ(cut->bytes, bytes);
  }
  EXPECT_EQ(fetches_, 1 + 2 * static_cast<int>(bytes.size()));
}

TEST_F(BlobCacheTest, RefusesWhatIsNoDigest) {
  EXPECT_EQ(open()->find("../../etc/passwd").status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(open()->get("", fetch_of("")).status().code(), absl::StatusCode::kInvalidArgument);
}

TEST_F(BlobCacheTest, OneFetchServesAllWhoAskAtOnce) {
  const std::string all(100'000, 'b');
  const std::string digest = wire::sha256_hex(all);
  const auto one = open();
  const auto other = open();  // stands for another process
  std::atomic<int> fetches{0};
  const auto fetch = [&](std::uint64_t offset, const BlobCache::Sink& sink) {
    ++fetches;
    return sink(std::string_view{all}.substr(offset));
  };
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < 8; ++i) {
      threads.emplace_back([&, i] {
        const auto bytes = (i % 2 == 0 ? one : other)->get(digest, fetch);
        ASSERT_TRUE(bytes.ok()) << bytes.status();
        EXPECT_EQ(bytes->bytes, all);
      });
    }
  }
  EXPECT_EQ(fetches, 1);
}

TEST_F(BlobCacheTest, RemovesTheBlobsUsedLongestAgo) {
  const auto cache = open(/*cap_bytes=*/2'500);
  const std::string a(1'000, 'a'), b(1'000, 'b'), c(1'000, 'c');
  const auto mapped = cache->get(wire::sha256_hex(a), fetch_of(a));
  ASSERT_TRUE(mapped.ok());
  ASSERT_TRUE(cache->get(wire::sha256_hex(b), fetch_of(b)).ok());
  // Clocks of file systems are coarse: the order of use is set by hand.
  for (const auto& entry : fs::recursive_directory_iterator{dir_.path()}) {
    if (!entry.is_regular_file()) continue;
    const bool is_a = entry.path().filename() == wire::sha256_hex(a);
    fs::last_write_time(entry, fs::file_time_type::clock::now() - std::chrono::hours{is_a ? 2 : 1});
  }
  ASSERT_TRUE(cache->get(wire::sha256_hex(c), fetch_of(c)).ok());
  EXPECT_FALSE(cache->find(wire::sha256_hex(a))->has_value());
  EXPECT_TRUE(cache->find(wire::sha256_hex(b))->has_value());
  EXPECT_TRUE(cache->find(wire::sha256_hex(c))->has_value());
  EXPECT_EQ(mapped->bytes, a) << "who has it mapped keeps its bytes";
}

TEST_F(BlobCacheTest, SaysWhichDirectoryCannotBeUsed) {
  const fs::path file = dir_.path() / "file";
  std::ofstream{file} << "x";
  const auto cache = BlobCache::open(base::machine_clock(), file, 1);
  EXPECT_EQ(cache.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_NE(std::string{cache.status().message()}.find(file.string()), std::string::npos);
}

}  // namespace
}  // namespace tessera::agent
