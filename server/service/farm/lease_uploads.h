// Blobs that workers bring for units of phases, until a result names them.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/status/status.h"
#include "tessera/v1/blob_ref.pb.h"
#include "tessera/v1/work.pb.h"

namespace tessera::server {

/// A lease calls for one blob. Not thread-safe. Time is given by the caller.
class LeaseUploads {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  static constexpr std::uint64_t kMostBlobBytes = std::uint64_t{8} << 30;
  static constexpr std::uint64_t kMostIdentityBytes = std::uint64_t{32} << 30;
  /// A blob that no result names for so long is to be deleted; a worker that still waits uploads it again.
  static constexpr std::chrono::minutes kKept{10};

  /// The lease brings the blob, or goes on with it. InvalidArgument where it has brought another, or the blob
  /// is too large for one; ResourceExhausted where the identity would have too much that no result names.
  absl::Status begin(const v1::LeaseToken& lease, const v1::BlobRef& blob, const std::string& identity,
                     TimePoint now);
  /// A result that counts names the blob.
  void claim(const std::string& digest);
  /// Blobs that were begun kKept ago and earlier; they are forgotten.
  std::vector<std::string> take_old(TimePoint now);

  std::uint64_t held_by(const std::string& identity) const;

 private:
  struct Upload {
    std::string lease, identity;
    std::uint64_t size = 0;
    TimePoint begun{};
  };
  using Uploads = absl::flat_hash_map<std::string, Upload>;  // key: digest
  void forget(Uploads::iterator upload);

  Uploads uploads_;
  absl::flat_hash_map<std::string, std::string> digest_by_lease_;
  absl::flat_hash_map<std::string, std::uint64_t> held_bytes_by_identity_;
};

}  // namespace tessera::server
