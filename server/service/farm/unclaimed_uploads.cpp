#include "service/farm/unclaimed_uploads.h"

#include <utility>

namespace tessera::server {

void UnclaimedUploads::note(const std::string& digest, std::uint64_t bytes, TimePoint now) {
  if (now >= next_turn_) {
    // Nothing was noted for so long that what is left is older still.
    if (now >= next_turn_ + lifetime_) bytes_.clear();
    older_ = std::exchange(bytes_, {});
    next_turn_ = now + lifetime_;
  }
  bytes_[digest] = take(digest) + bytes;
}

std::uint64_t UnclaimedUploads::claim(const v1::JobSpec& spec) {
  std::uint64_t bytes = 0;
  for (const v1::BlobRef& blob : spec.farm().blobs()) bytes += take(blob.digest());
  return bytes;
}

std::uint64_t UnclaimedUploads::take(const std::string& digest) {
  std::uint64_t bytes = 0;
  for (auto* const map : {&bytes_, &older_}) {
    if (const auto found = map->find(digest); found != map->end()) {
      bytes += found->second;
      map->erase(found);
    }
  }
  return bytes;
}

}  // namespace tessera::server
