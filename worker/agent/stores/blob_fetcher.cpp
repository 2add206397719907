#include "agent/stores/blob_fetcher.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <system_error>
#include <utility>
#include <vector>

#include "net/backoff.h"
#include "net/status.h"

namespace tessera::agent {
namespace {

constexpr int kMaxCorruptDownloads = 3;
constexpr int kParallelDownloads = 4;

}  // namespace

BlobFetcher::BlobFetcher(base::Clock& clock, CoordinatorLink& link, BlobCache& cache)
    : clock_(clock), link_(link), cache_(cache) {}

absl::StatusOr<render::BlobBytes> BlobFetcher::get(const std::string& digest, std::stop_token stop) {
  bool missed = false;
  int corrupt = 0;
  const auto fetch = [&](std::uint64_t offset, const BlobCache::Sink& sink) {
    if (!std::exchange(missed, true)) ++misses_;
    const auto count_and_sink = [&](std::string_view chunk) {
      downloaded_bytes_ += chunk.size();
      return sink(chunk);
    };
    return link_.download({.digest = digest, .offset = offset, .doubted = corrupt > 0}, count_and_sink, stop);
  };
  net::Backoff backoff{std::chrono::milliseconds{100}, std::chrono::milliseconds{2000}};
  while (true) {
    absl::StatusOr<render::BlobBytes> bytes = cache_.get(digest, fetch);
    if (bytes.ok()) {
      if (!missed) ++hits_;
      return bytes;
    }
    if (stop.stop_requested()) return absl::CancelledError("stopped while fetching a blob");
    const absl::Status& status = bytes.status();
    const bool try_again =
        net::is_transient(status) || (absl::IsDataLoss(status) && ++corrupt < kMaxCorruptDownloads);
    if (!try_again) return status;
    spdlog::warn("blob {}: {}; trying again", digest, status.ToString());
    if (!link_.wait(backoff, stop)) return absl::CancelledError("stopped while fetching a blob");
  }
}

void BlobFetcher::add_to(AgentReport& report) const {
  report.downloaded_bytes = downloaded_bytes_;
  report.cache_hits = hits_;
  report.cache_misses = misses_;
}

void BlobFetcher::prefetch(const v1::JobSpec& spec, std::stop_token stop) {
  const auto& blobs = spec.farm().blobs();  // the scene is there already
  std::atomic<int> next{0};
  std::atomic<bool> failed{false};
  const auto take_and_fetch = [&] {
    for (int i = next++; i < blobs.size() && !failed && !stop.stop_requested(); i = next++) {
      const std::string& digest = blobs[i].digest();
      if (digest != spec.content().scene() && !get(digest, stop).ok()) failed = true;
    }
  };
  std::vector<base::Thread> helpers;
  try {
    for (int i = 1; i < std::min(kParallelDownloads, blobs.size()); ++i)
      helpers.push_back(clock_.start("download", [&](std::stop_token) { take_and_fetch(); }));
  } catch (const std::system_error&) {  // no memory for one more stack: those that there are fetch all
  }
  take_and_fetch();
}

}  // namespace tessera::agent
