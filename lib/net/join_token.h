// Token that a new worker needs to join a farm: a secret, where to say it, and whom to say it to.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace tessera::net {

/// Token, as text "tessera-join:PORT:DIGEST:SECRET". Whoever has it may become a worker of the farm, for as
/// long as the coordinator accepts it.
struct JoinToken {
  std::uint16_t port = 0;        // port of the coordinator's JoinService
  std::string authority_digest;  // SHA-256 of the certificate of the farm's authority, 64 hexadecimal digits
  std::string secret;            // kSecretDigits hexadecimal digits

  static constexpr std::size_t kSecretDigits = 32;  // 128 bits

  std::string to_string() const;
};

/// InvalidArgument for anything else. The message does not repeat the text: it goes into logs.
absl::StatusOr<JoinToken> parse_join_token(std::string_view text);

}  // namespace tessera::net
