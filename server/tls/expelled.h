// Whose certificates a farm does not accept any more, though they are valid.
#pragma once

#include <chrono>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "absl/status/statusor.h"
#include "tls/role.h"

namespace tessera::server {

/// When a farm's authority made a certificate, given in PEM; nothing when that cannot be read.
std::optional<std::chrono::system_clock::time_point> time_made(std::string_view certificate_pem);

/// InvalidArgument for a name that no certificate of a farm has.
absl::Status check_member_name(std::string_view name);

/// Role and name of a certificate, with the time at which they were expelled: certificates that were made
/// until then are refused, later ones are not. Kept in one file. Thread-safe. Time is given by the caller.
class Expelled {
 public:
  using Time = std::chrono::system_clock::time_point;

  static constexpr std::size_t kMostNames = 10'000;
  static constexpr std::size_t kLongestName = 64;  // length of the longest name that an authority certifies

  /// An empty path: in memory. Unavailable, or DataLoss, for a file that cannot be read.
  static absl::StatusOr<std::unique_ptr<Expelled>> open(std::filesystem::path file);

  /// Durable when it returns. InvalidArgument for a name that no certificate of a farm has, ResourceExhausted
  /// when there are too many.
  absl::Status expel(Role role, const std::string& name, Time now);
  /// NotFound when they were not expelled.
  absl::Status readmit(Role role, const std::string& name);

  /// Whether a certificate, in PEM, that says this role and this name is refused. One that cannot be read is,
  /// where the name is expelled.
  bool refuses(Role role, const std::string& name, std::string_view certificate_pem) const;

 private:
  using Members = std::map<std::pair<Role, std::string>, Time>;

  explicit Expelled(std::filesystem::path file) : file_(std::move(file)) {}
  absl::Status read();
  absl::Status write(const Members& members) const;

  const std::filesystem::path file_;
  mutable std::mutex mutex_;
  Members members_;
};

}  // namespace tessera::server
