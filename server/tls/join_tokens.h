// The join tokens that a coordinator accepts.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace tessera::server {

/// Keeps the digests of the secrets, not the secrets, in one file. Thread-safe. Time is given by the caller.
class JoinTokens {
 public:
  using Time = std::chrono::system_clock::time_point;

  static constexpr std::chrono::hours kLongestLife{24 * 30};
  static constexpr std::uint32_t kMostUses = 10'000;
  static constexpr std::size_t kMostTokens = 1'000;      // tokens at a time
  static constexpr std::uint32_t kFailuresAMinute = 10;  // failures from one address
  /// Addresses whose failures are counted at a time; beyond them, new ones have to wait.
  static constexpr std::size_t kMostAddresses = 1'000;

  /// An empty path: in memory. Unavailable, or DataLoss, for a file that cannot be read.
  static absl::StatusOr<JoinTokens> open(std::filesystem::path file);

  JoinTokens(JoinTokens&& other) noexcept : file_(other.file_), tokens_(std::move(other.tokens_)) {}

  /// A secret that is accepted `uses` times until `now + life`; durable when it returns. InvalidArgument for
  /// a life or a number that is not within the bounds above, ResourceExhausted when there are too many.
  absl::StatusOr<std::string> make(std::chrono::seconds life, std::uint32_t uses, Time now);

  /// Takes one use of a secret's token for `member`; durable when it returns. PermissionDenied when there is
  /// no such token or its time is over; ResourceExhausted, whatever the secret, after kFailuresAMinute of
  /// those from `address`.
  absl::Status redeem(const std::string& secret, const std::string& member, const std::string& address,
                      Time now);

  /// Tokens that `member` joined with, and so knows, are not accepted any more; durable when it returns. How
  /// many that were.
  absl::StatusOr<std::size_t> call_back(const std::string& member);

 private:
  struct Token {
    std::string secret_digest;
    std::int64_t expires_unix_s = 0;
    std::uint32_t uses_left = 0;
    std::vector<std::string> members = {};  // who joined with it
  };

  explicit JoinTokens(std::filesystem::path file) : file_(std::move(file)) {}
  absl::Status read();
  absl::Status write(const std::vector<Token>& tokens) const;
  bool may_try(const std::string& address, Time now);

  const std::filesystem::path file_;
  std::mutex mutex_;
  std::vector<Token> tokens_;
  std::map<std::string, std::uint32_t> failures_by_address_;  // within the minute that began at minute_
  Time minute_{};
};

}  // namespace tessera::server
