#include "service/web/logins.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "service/identifier.h"
#include "wire/digest.h"

namespace tessera::server {

std::string name_of_member(const Visitor& who) {
  return who.caller.role ? absl::StrCat(to_string(*who.caller.role), " ", who.caller.user) : "";
}

absl::StatusOr<std::string> Logins::add(Entries& entries, const Visitor& who, Time until, Time now) {
  std::erase_if(entries, [now](const auto& entry) { return entry.second.until <= now; });
  const auto is_of_caller = [&who](const auto& entry) {
    const Caller& caller = entry.second.who.caller;
    return caller.role == who.caller.role && caller.user == who.caller.user;
  };
  if (std::cmp_greater_equal(std::ranges::count_if(entries, is_of_caller), kMostOfOneCaller)) {
    auto oldest = entries.end();
    for (auto entry = entries.begin(); entry != entries.end(); ++entry) {
      if (is_of_caller(*entry) && (oldest == entries.end() || entry->second.until < oldest->second.until))
        oldest = entry;
    }
    entries.erase(oldest);
  }
  if (entries.size() >= kMost)
    return absl::ResourceExhaustedError("there are too many logins to the web page; try again later");
  std::string secret = random_identifier(kSecretDigits);
  entries[wire::sha256_hex(secret)] = {.who = who, .until = until};
  return secret;
}

absl::StatusOr<std::string> Logins::make_token(const Visitor& who, std::chrono::seconds life, Time now) {
  if (life < std::chrono::seconds{1} || life > kLongestToken)
    return absl::InvalidArgumentError("a login token is good for 1 s to 24 h");
  const std::lock_guard lock(mutex_);
  return add(tokens_, who, now + life, now);
}

absl::StatusOr<std::string> Logins::begin(const std::string& token, Time now) {
  const std::lock_guard lock(mutex_);
  const auto found = tokens_.extract(wire::sha256_hex(token));
  if (!found || found.mapped().until <= now)
    return absl::PermissionDeniedError("the login token is not valid: wrong, used, or too old");
  return add(sessions_, found.mapped().who, now + kSession, now);
}

std::optional<Visitor> Logins::find(const std::string& session, Time now) {
  if (session.size() != kSecretDigits) return std::nullopt;
  const std::lock_guard lock(mutex_);
  const auto found = sessions_.find(wire::sha256_hex(session));
  if (found == sessions_.end() || found->second.until <= now) return std::nullopt;
  return found->second.who;
}

void Logins::end(const std::string& session) {
  const std::lock_guard lock(mutex_);
  sessions_.erase(wire::sha256_hex(session));
}

}  // namespace tessera::server
