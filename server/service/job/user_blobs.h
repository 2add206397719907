// Which user's jobs name which blobs, and how many bytes these are.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/container/inlined_vector.h"
#include "tessera/v1/job.pb.h"

namespace tessera::server {

/// Each blob counts once for every user whose jobs name it, however many of them do. Some 80 bytes a blob.
/// Not thread-safe.
class UserBlobs {
 public:
  /// A job is kept whose blobs have these sizes, in the order of its spec.
  void add(const v1::JobSpec& spec, const std::vector<std::uint64_t>& sizes);
  /// It is kept no more.
  void remove(const v1::JobSpec& spec);

  std::uint64_t bytes_of(const std::string& user) const;
  /// Returns the bytes with one more job, of the user whom its spec names.
  std::uint64_t bytes_with(const v1::JobSpec& spec, const std::vector<std::uint64_t>& sizes) const;
  /// Size of a blob that some job names.
  std::optional<std::uint64_t> size_of(const std::string& digest) const;

 private:
  using Key = std::array<char, 32>;  // the digest's bytes
  using UserNumber = std::uint32_t;
  struct Blob {
    std::uint64_t size = 0;
    /// How often each user's jobs name it.
    absl::InlinedVector<std::pair<UserNumber, std::uint32_t>, 1> uses_by_user;
  };
  static Key key_of(const std::string& digest);
  static bool is_used_by(const Blob& blob, std::optional<UserNumber> user);

  absl::flat_hash_map<Key, Blob> blobs_;
  absl::flat_hash_map<std::string, UserNumber> users_;
  std::vector<std::uint64_t> bytes_by_user_;
};

}  // namespace tessera::server
