#include "service/farm/unclaimed_uploads.h"

namespace tessera::server {

std::uint64_t UnclaimedUploads::claim(const v1::JobSpec& spec) {
  std::uint64_t bytes = 0;
  const auto claim = [&](const v1::BlobRef& blob) {
    if (const auto found = bytes_.find(blob.digest()); found != bytes_.end()) {
      bytes += found->second;
      bytes_.erase(found);
    }
  };
  for (const v1::BlobRef& blob : spec.farm().blobs()) claim(blob);
  return bytes;
}

}  // namespace tessera::server
