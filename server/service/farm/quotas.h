// Upper bounds of what one user may ask of the farm.
#pragma once

#include <cstdint>
#include <string>

#include "absl/container/flat_hash_map.h"
#include "absl/status/status.h"

namespace tessera::server {

/// A number for every user, and others for some.
template <class Number>
struct PerUser {
  Number of_all;
  absl::flat_hash_map<std::string, Number> of_some = {};

  Number of(const std::string& user) const {
    const auto found = of_some.find(user);
    return found == of_some.end() ? of_all : found->second;
  }
};

/// Reads "NUMBER", for every user, or "USER=NUMBER", for one. InvalidArgument says what is wrong.
absl::Status read_quota(const std::string& text, PerUser<std::int32_t>& quota);
absl::Status read_quota(const std::string& text, PerUser<std::uint64_t>& quota);
/// The same in GB, which may have a fraction.
absl::Status read_gigabytes(const std::string& text, PerUser<std::uint64_t>& quota);

/// A user's share of the farm, with what is asked for.
struct UserShare {
  std::uint64_t open_jobs = 0;
  std::uint64_t units = 0;       // units of jobs whose units are in memory
  std::uint64_t blob_bytes = 0;  // the blobs that the user's jobs name, and uploads that no job named
};

/// They hold for callers with the certificate of a client (Caller::has_quotas).
struct Quotas {
  static constexpr std::uint64_t kUnbounded = ~std::uint64_t{0};

  PerUser<std::int32_t> priority{.of_all = 0};
  PerUser<std::uint64_t> open_jobs{.of_all = 10'000};
  PerUser<std::uint64_t> units{.of_all = std::uint64_t{1} << 25};
  PerUser<std::uint64_t> blob_bytes{.of_all = kUnbounded};

  /// PermissionDenied for a priority that is too high for `user`.
  absl::Status check_priority(const std::string& user, std::int32_t asked) const;
  /// ResourceExhausted, by name, for what would be too much for `user`.
  absl::Status check_share(const std::string& user, const UserShare& share) const;
  absl::Status check_blob_bytes(const std::string& user, std::uint64_t bytes) const;
};

}  // namespace tessera::server
