// Whom a farm has seen: who called with a certificate, or joined.
#pragma once

#include <filesystem>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <utility>

#include "absl/status/statusor.h"
#include "tls/role.h"

namespace tessera::server {

/// Roles and names of certificates, kept in one file, a line each. It only helps against typing errors: when
/// it cannot be written, a member is noted again the next time that it calls. Thread-safe.
class Members {
 public:
  static constexpr std::size_t kMost = 100'000;  // later ones are not noted

  /// An empty path: in memory. Unavailable for a file that cannot be read; lines that cannot be understood
  /// are left out.
  static absl::StatusOr<std::unique_ptr<Members>> open(std::filesystem::path file);

  void note(Role role, const std::string& name);
  bool has_seen(Role role, const std::string& name) const;
  /// NotFound for a member that was not seen: with those that joined as machines of that name, or else with
  /// the nearest that was seen.
  absl::Status check_seen(Role role, const std::string& name) const;

 private:
  explicit Members(std::filesystem::path file) : file_(std::move(file)) {}

  const std::filesystem::path file_;
  mutable std::mutex mutex_;
  std::set<std::pair<Role, std::string>> seen_;
};

}  // namespace tessera::server
