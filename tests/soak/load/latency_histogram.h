// How long calls took, from any number of threads.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <chrono>
#include <cstdint>

namespace tessera::load {

/// Counts in buckets of a sixteenth of an octave, so that a quantile is right within 5 %. Thread-safe.
class LatencyHistogram {
 public:
  using Duration = std::chrono::microseconds;

  void add(Duration duration) {
    const auto us = static_cast<std::uint64_t>(std::max<std::int64_t>(duration.count(), 0));
    buckets_[std::min(bucket_of(us), kBuckets - 1)].fetch_add(1, std::memory_order_relaxed);
  }

  void clear() {
    for (auto& bucket : buckets_) bucket = 0;
  }

  std::uint64_t count() const {
    std::uint64_t sum = 0;
    for (const auto& bucket : buckets_) sum += bucket.load(std::memory_order_relaxed);
    return sum;
  }

  /// The upper end of the bucket below which the fraction `q` of all lies; zero where there are none.
  Duration quantile(double q) const {
    const auto wanted = static_cast<std::uint64_t>(q * static_cast<double>(count()));
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < kBuckets; ++i) {
      sum += buckets_[i].load(std::memory_order_relaxed);
      if (sum > 0 && sum >= wanted) return Duration(static_cast<std::int64_t>(begin_of(i + 1)));
    }
    return Duration{0};
  }

 private:
  static constexpr std::size_t kSteps = 16;  // an octave
  static constexpr std::size_t kBuckets = 40 * kSteps;

  // Below 16 every value has its own bucket; from there on the four bits after the leading one choose.
  static std::size_t bucket_of(std::uint64_t us) {
    if (us < kSteps) return static_cast<std::size_t>(us);
    const auto octave = static_cast<std::size_t>(std::bit_width(us)) - 5;
    return octave * kSteps + static_cast<std::size_t>(us >> octave);
  }
  static std::uint64_t begin_of(std::size_t bucket) {
    if (bucket < 2 * kSteps) return bucket;
    const std::size_t octave = bucket / kSteps - 1;
    return std::uint64_t{bucket % kSteps + kSteps} << octave;
  }

  std::array<std::atomic<std::uint64_t>, kBuckets> buckets_{};
};

}  // namespace tessera::load
