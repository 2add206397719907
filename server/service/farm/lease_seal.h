// Proof that a lease was granted, and to whom: without a record of each grant, and over restarts of the
// coordinator.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "tessera/v1/work.pb.h"

namespace tessera::server {

/// Seals lease tokens with a key that only the coordinator has: HMAC-SHA-256 [RFC2104] over the token and the
/// host that it was granted to. Thread-safe.
class LeaseSeal {
 public:
  static constexpr std::size_t kKeyBytes = 32;
  static constexpr std::size_t kSealBytes = 16;  // the first of the 32 that HMAC gives

  /// The key in `file`, made when there is none; an empty path: a new one, in memory. Unavailable for a file
  /// that cannot be read or written, DataLoss for one that holds no key.
  static absl::StatusOr<std::shared_ptr<const LeaseSeal>> open(const std::filesystem::path& file);
  /// With a key of `kKeyBytes` bytes that somebody else keeps.
  static std::shared_ptr<const LeaseSeal> with_key(std::string key);

  /// Seals a token for a host.
  void seal(v1::LeaseToken& token, std::string_view host) const;
  /// Whether the token was sealed for this host.
  bool is_sealed(const v1::LeaseToken& token, std::string_view host) const;

  /// A key of its own for another purpose, of which nobody learns by seals.
  std::string derive_key(std::string_view purpose) const;

 private:
  explicit LeaseSeal(std::string key) : key_(std::move(key)) {}
  std::string hmac(std::string_view message) const;

  const std::string key_;
};

}  // namespace tessera::server
