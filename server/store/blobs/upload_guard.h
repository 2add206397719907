// One writer a blob at a time.
#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "absl/container/flat_hash_set.h"

namespace tessera::server {

/// The digests that are being written. Outlives the store through its guards.
class UploadsUnderWay : public std::enable_shared_from_this<UploadsUnderWay> {
 public:
  /// Holds a digest until it goes away.
  class Guard {
   public:
    Guard(std::shared_ptr<UploadsUnderWay> uploads, std::string digest)
        : uploads_(std::move(uploads)), digest_(std::move(digest)) {}
    ~Guard() {
      const std::lock_guard lock(uploads_->mutex_);
      uploads_->digests_.erase(digest_);
    }
    Guard(const Guard&) = delete;
    Guard& operator=(const Guard&) = delete;

   private:
    std::shared_ptr<UploadsUnderWay> uploads_;
    std::string digest_;
  };

  /// Null when somebody holds the digest.
  std::unique_ptr<Guard> hold(const std::string& digest) {
    const std::lock_guard lock(mutex_);
    if (!digests_.insert(digest).second) return nullptr;
    return std::make_unique<Guard>(shared_from_this(), digest);
  }

 private:
  std::mutex mutex_;
  absl::flat_hash_set<std::string> digests_;
};

}  // namespace tessera::server
