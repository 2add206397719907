#include "agent/blob_fetcher.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <mutex>
#include <thread>
#include <vector>

#include "wire/backoff.h"
#include "wire/status.h"

namespace tessera::agent {
namespace {

constexpr int kMaxCorruptDownloads = 3;
constexpr std::size_t kParallelDownloads = 4;

}  // namespace

BlobFetcher::BlobFetcher(CoordinatorLink& link, BlobCache& cache) : link_(link), cache_(cache) {}

absl::StatusOr<render::BlobBytes> BlobFetcher::get(const std::string& digest, std::stop_token stop) {
  const auto fetch = [&](std::uint64_t offset, const BlobCache::Sink& sink) {
    const auto count_and_sink = [&](std::string_view chunk) {
      downloaded_bytes_ += chunk.size();
      return sink(chunk);
    };
    return link_.download(digest, offset, count_and_sink, stop);
  };
  wire::Backoff backoff{std::chrono::milliseconds{100}, std::chrono::milliseconds{2000}};
  int corrupt = 0;
  while (true) {
    absl::StatusOr<render::BlobBytes> bytes = cache_.get(digest, fetch);
    if (bytes.ok()) return bytes;
    if (stop.stop_requested()) return absl::CancelledError("stopped while fetching a blob");
    const absl::Status& status = bytes.status();
    const bool try_again = wire::is_transient(status) || (absl::IsDataLoss(status) && ++corrupt < kMaxCorruptDownloads);
    if (!try_again) return status;
    spdlog::warn("blob {}: {}; trying again", digest, status.ToString());
    if (!backoff.wait(stop)) return absl::CancelledError("stopped while fetching a blob");
  }
}

absl::Status BlobFetcher::prefetch(const v1::JobSpec& spec, std::stop_token stop) {
  std::vector<std::string> digests{spec.scene().digest()};
  for (const v1::BlobRef& blob : spec.blobs()) digests.push_back(blob.digest());

  std::mutex mutex;
  absl::Status first_error;
  std::size_t next = 0;
  const auto take_and_fetch = [&] {
    while (true) {
      std::string digest;
      {
        std::lock_guard lock{mutex};
        if (next == digests.size() || !first_error.ok()) return;
        digest = digests[next++];
      }
      const absl::StatusOr<render::BlobBytes> bytes = get(digest, stop);
      std::lock_guard lock{mutex};
      if (!bytes.ok()) first_error.Update(bytes.status());
    }
  };
  {
    std::vector<std::jthread> helpers;
    const std::size_t threads = std::min(kParallelDownloads, digests.size());
    for (std::size_t i = 1; i < threads; ++i) helpers.emplace_back(take_and_fetch);
    take_and_fetch();
  }
  return first_error;
}

}  // namespace tessera::agent
