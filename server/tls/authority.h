// A farm's own certificate authority: files in one folder.
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "tls/role.h"

namespace tessera::server {

/// Whom a certificate is for.
struct Identity {
  Role role = Role::kClient;
  std::string name;                // a client's is the user of its jobs
  std::vector<std::string> hosts;  // names and addresses that a server is called by
};

/// How long certificates are valid: what browsers accept at most, a habit worth having. From a little
/// earlier, for clocks that are late.
inline constexpr std::chrono::hours kCertificateLife{24 * 397};
inline constexpr std::chrono::hours kClockSlack{1};

class Authority {
 public:
  /// The authority in `folder`, made when there is none. Unavailable for files that cannot be read or
  /// written, InvalidArgument for files that are none of an authority.
  static absl::StatusOr<Authority> open(const std::filesystem::path& folder);
  /// The same, but Unavailable when there is none.
  static absl::StatusOr<Authority> open_existing(const std::filesystem::path& folder);

  Authority(Authority&&) noexcept;
  Authority& operator=(Authority&&) noexcept;
  ~Authority();

  /// Makes a key and a certificate, valid from `begin` to `end`, and writes them with the authority's own
  /// certificate into `folder`, under the names of net/tls.h. What is there is replaced, file by file.
  /// The key is readable by its owner only.
  absl::Status issue(const Identity& identity, const std::filesystem::path& folder,
                     std::chrono::system_clock::time_point begin,
                     std::chrono::system_clock::time_point end) const;

  /// A certificate, in PEM, for the holder of the key that `request_pem` (PKCS #10) is made and signed with.
  /// Whom it is for is said by `identity` alone, not by the request. InvalidArgument for a request, a key or
  /// a name that is unsound.
  absl::StatusOr<std::string> certify(const std::string& request_pem, const Identity& identity,
                                      std::chrono::system_clock::time_point begin,
                                      std::chrono::system_clock::time_point end) const;

  /// Its own certificate, and the SHA-256 of that.
  std::string certificate_pem() const;
  std::string digest() const;
  /// Whether it is among those that a program's folder (net/tls.h) trusts.
  bool is_trusted_by(const std::filesystem::path& folder) const;

 private:
  struct Parts;
  explicit Authority(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

/// All that a farm needs, one folder a program: "authority", "server", "worker", "admin", and "client-NAME"
/// for each of `users`. An authority that is there stays; the other certificates are renewed, for 397 days.
/// `hosts`: what the server is called by, beside "localhost", the loopback addresses and this machine's name.
absl::Status write_farm_certificates(const std::filesystem::path& folder,
                                     const std::vector<std::string>& hosts,
                                     const std::vector<std::string>& users);

}  // namespace tessera::server
