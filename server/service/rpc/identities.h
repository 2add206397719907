// Who is at the other end of a call, by the key of their certificate.
#pragma once

#include <grpcpp/grpcpp.h>

#include <mutex>
#include <string>

#include "absl/container/flat_hash_map.h"

namespace tessera::server {

/// Keeps what it has read, for certificates come with every call. Thread-safe.
class Identities {
 public:
  static constexpr std::size_t kMostKept = 16'384;  // certificates

  /// The fingerprint of the caller's key (identity.h): whoever has a certificate of the same key is the same.
  /// Empty for a caller without a certificate. One that cannot be read is an identity of its own.
  std::string of(const grpc::AuthContext* context);

 private:
  std::mutex mutex_;
  absl::flat_hash_map<std::string, std::string> by_pem_;
};

}  // namespace tessera::server
