#include "tls/join_tokens.h"

#include <openssl/crypto.h>
#include <openssl/rand.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <sstream>
#include <utility>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "base/private_file.h"
#include "net/join_token.h"
#include "tls/unix_time.h"
#include "wire/digest.h"

namespace tessera::server {

absl::StatusOr<JoinTokens> JoinTokens::open(std::filesystem::path file) {
  JoinTokens tokens{std::move(file)};
  if (absl::Status status = tokens.read(); !status.ok()) return status;
  return tokens;
}

absl::Status JoinTokens::read() {
  if (file_.empty() || !std::filesystem::exists(file_)) return absl::OkStatus();
  std::ifstream in{file_};
  if (!in) return absl::UnavailableError(absl::StrCat(file_.string(), " cannot be read"));
  for (std::string line; std::getline(in, line);) {
    std::istringstream words{line};
    Token token;
    if (!(words >> token.secret_digest >> token.expires_unix_s >> token.uses_left) ||
        !wire::is_digest(token.secret_digest)) {
      return absl::DataLossError(
          absl::StrCat(file_.string(), ": \"", line, "\" is no join token; remove the file"));
    }
    for (std::string member; words >> member;) token.members.push_back(absl::HexStringToBytes(member));
    tokens_.push_back(std::move(token));
  }
  return absl::OkStatus();
}

absl::Status JoinTokens::write(const std::vector<Token>& tokens) const {
  if (file_.empty()) return absl::OkStatus();
  std::string text;
  for (const Token& token : tokens) {
    absl::StrAppend(&text, token.secret_digest, " ", token.expires_unix_s, " ", token.uses_left);
    for (const std::string& member : token.members)
      absl::StrAppend(&text, " ", absl::BytesToHexString(member));
    text += '\n';
  }
  return base::replace_file(file_, 0600, text);
}

absl::StatusOr<std::string> JoinTokens::make(std::chrono::seconds life, std::uint32_t uses, Time now) {
  if (life < std::chrono::seconds{1} || life > kLongestLife || uses < 1 || uses > kMostUses) {
    return absl::InvalidArgumentError(
        absl::StrCat("a join token lives for 1 second to 30 days and is used 1 to ", kMostUses, " times"));
  }
  std::array<unsigned char, net::JoinToken::kSecretDigits / 2> random{};
  if (RAND_bytes(random.data(), static_cast<int>(random.size())) != 1) {
    return absl::InternalError("no random numbers for a join token");
  }
  const std::string secret =
      absl::BytesToHexString({reinterpret_cast<const char*>(random.data()), random.size()});
  const std::lock_guard lock{mutex_};
  std::vector<Token> tokens = tokens_;
  std::erase_if(tokens, [&](const Token& token) { return token.expires_unix_s <= unix_seconds(now); });
  if (tokens.size() >= kMostTokens)
    return absl::ResourceExhaustedError("there are too many join tokens already");
  tokens.push_back({wire::sha256_hex(secret), unix_seconds(now + life), uses});
  if (absl::Status status = write(tokens); !status.ok()) return status;
  tokens_ = std::move(tokens);
  return secret;
}

absl::StatusOr<std::size_t> JoinTokens::call_back(const std::string& member) {
  const std::lock_guard lock{mutex_};
  std::vector<Token> tokens = tokens_;
  const std::size_t called_back = std::erase_if(tokens, [&](const Token& token) {
    return std::find(token.members.begin(), token.members.end(), member) != token.members.end();
  });
  if (called_back == 0) return called_back;
  if (absl::Status status = write(tokens); !status.ok()) return status;
  tokens_ = std::move(tokens);
  return called_back;
}

bool JoinTokens::may_try(const std::string& address, Time now) {
  // Also when the clock was set back.
  if (now - minute_ >= std::chrono::minutes{1} || now < minute_) {
    failures_by_address_.clear();
    minute_ = now;
  }
  const auto found = failures_by_address_.find(address);
  return found == failures_by_address_.end() ? failures_by_address_.size() < kMostAddresses
                                             : found->second < kFailuresAMinute;
}

absl::Status JoinTokens::redeem(const std::string& secret, const std::string& member,
                                const std::string& address, Time now) {
  const std::string digest = wire::sha256_hex(secret);
  const std::lock_guard lock{mutex_};
  if (!may_try(address, now)) {
    return absl::ResourceExhaustedError(
        "too many wrong join tokens from this address; try again in a minute");
  }
  // Every token is looked at, and all of its digest, so that the time this takes tells nothing.
  std::vector<Token> tokens = tokens_;
  Token* known = nullptr;
  for (Token& token : tokens) {
    if (CRYPTO_memcmp(token.secret_digest.data(), digest.data(), digest.size()) == 0) known = &token;
  }
  if (known == nullptr || known->expires_unix_s <= unix_seconds(now)) {
    ++failures_by_address_[address];
    return absl::PermissionDeniedError(known == nullptr ? "the join token is not known, or used up"
                                                        : "the join token is expired");
  }
  auto& members = known->members;
  if (std::find(members.begin(), members.end(), member) == members.end()) members.push_back(member);
  if (--known->uses_left == 0) tokens.erase(tokens.begin() + (known - tokens.data()));
  if (absl::Status status = write(tokens); !status.ok()) return status;
  tokens_ = std::move(tokens);
  return absl::OkStatus();
}

}  // namespace tessera::server
