// The certificate by which the web page shows who it is, and the authorities by which it knows others.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"

struct gnutls_pcert_st;
struct gnutls_privkey_st;

namespace tessera::server {

/// Key, certificate and authorities of a folder (net/tls.h), read anew when the files change.
/// Thread-safe.
class OwnCertificates {
 public:
  OwnCertificates();
  ~OwnCertificates();

  /// Reads them. Errors as net::check_certificates; then those that were there before stay.
  absl::Status read(const std::filesystem::path& folder);
  /// Whether the files were written since read() last looked at them.
  bool has_news(const std::filesystem::path& folder);

  /// Chain and key for a handshake of GnuTLS; valid for as long as this object.
  struct Shown {
    gnutls_pcert_st* chain = nullptr;
    unsigned length = 0;
    gnutls_privkey_st* key = nullptr;
  };
  Shown shown() const;

  /// The authorities, in PEM.
  std::string trusted() const;

 private:
  struct Pair;
  struct Written {
    std::filesystem::file_time_type key, certificate, trusted;
    friend bool operator==(const Written&, const Written&) = default;
  };
  static Written written(const std::filesystem::path& folder);

  mutable std::mutex mutex_;
  std::vector<std::unique_ptr<Pair>> pairs_;  // handshakes may use earlier ones: the last one is shown
  std::string trusted_;
  Written seen_{};
};

}  // namespace tessera::server
