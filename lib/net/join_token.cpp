#include "net/join_token.h"

#include <charconv>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "wire/digest.h"

namespace tessera::net {
namespace {

constexpr const char* kKind = "tessera-join";

bool is_secret(std::string_view text) {
  return text.size() == JoinToken::kSecretDigits &&
         text.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

}  // namespace

std::string JoinToken::to_string() const {
  return absl::StrCat(kKind, ":", port, ":", authority_digest, ":", secret);
}

absl::StatusOr<JoinToken> parse_join_token(std::string_view text) {
  const std::vector<std::string> parts = absl::StrSplit(std::string(text), ':');
  JoinToken token;
  const bool whole =
      parts.size() == 4 && parts[0] == kKind && wire::is_digest(parts[2]) && is_secret(parts[3]);
  if (whole) {
    const char* const end = parts[1].data() + parts[1].size();
    const auto [rest, error] = std::from_chars(parts[1].data(), end, token.port);
    if (error == std::errc() && rest == end && token.port != 0) {
      token.authority_digest = parts[2];
      token.secret = parts[3];
      return token;
    }
  }
  return absl::InvalidArgumentError(
      "this is no join token; expected tessera-join:PORT:DIGEST:SECRET, whole, as `tessera token` prints it");
}

}  // namespace tessera::net
