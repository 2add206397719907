#include "service/farm/unclaimed_uploads.h"

#include <utility>

#include "absl/container/flat_hash_set.h"

namespace tessera::server {

void UnclaimedUploads::begin(const std::string& digest, std::uint64_t size, const std::string& holder,
                             TimePoint now) {
  Upload upload = take(digest);
  upload.size = size;
  upload.holder = holder;
  put(digest, std::move(upload), now);
}

void UnclaimedUploads::note(const std::string& digest, std::uint64_t bytes, TimePoint now) {
  Upload upload = take(digest);
  upload.sent += bytes;
  put(digest, std::move(upload), now);
}

std::uint64_t UnclaimedUploads::claim(const v1::JobSpec& spec) {
  std::uint64_t bytes = 0;
  for (const v1::BlobRef& blob : spec.farm().blobs()) bytes += take(blob.digest()).sent;
  return bytes;
}

std::uint64_t UnclaimedUploads::held_of(const std::string& holder, const std::string& digest) const {
  for (const Uploads* const map : {&uploads_, &older_}) {
    if (const auto found = map->find(digest); found != map->end() && found->second.holder == holder)
      return found->second.size;
  }
  return 0;
}

std::uint64_t UnclaimedUploads::held_by(const std::string& holder, const std::string& but_for) const {
  const auto found = held_.find(holder);
  return found == held_.end() ? 0 : found->second - held_of(holder, but_for);
}

std::uint64_t UnclaimedUploads::held_by(const std::string& holder, const v1::JobSpec& spec) const {
  const auto found = held_.find(holder);
  if (found == held_.end()) return 0;
  std::uint64_t bytes = found->second;
  absl::flat_hash_set<std::string> seen;
  for (const v1::BlobRef& blob : spec.farm().blobs()) {
    if (seen.insert(blob.digest()).second) bytes -= held_of(holder, blob.digest());
  }
  return bytes;
}

UnclaimedUploads::Upload UnclaimedUploads::take(const std::string& digest) {
  for (Uploads* const map : {&uploads_, &older_}) {
    auto node = map->extract(digest);
    if (node.empty()) continue;
    const auto held = held_.find(node.mapped().holder);
    if (held != held_.end() && (held->second -= node.mapped().size) == 0) held_.erase(held);
    return std::move(node.mapped());
  }
  return {};
}

void UnclaimedUploads::put(const std::string& digest, Upload upload, TimePoint now) {
  if (now >= next_turn_) {
    // Nothing was noted for so long that what is left is older still.
    const bool all = now >= next_turn_ + lifetime_;
    const auto drop = [this](Uploads& uploads) {
      for (const auto& [other, old] : Uploads{uploads}) static_cast<void>(take(other));
      uploads.clear();
    };
    drop(older_);
    if (all) drop(uploads_);
    older_ = std::exchange(uploads_, {});
    next_turn_ = now + lifetime_;
  }
  if (!upload.holder.empty() && upload.size > 0) held_[upload.holder] += upload.size;
  uploads_[digest] = std::move(upload);
}

}  // namespace tessera::server
