// Who has logged in to the web page.
#pragma once

#include <chrono>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "service/farm/rights.h"

namespace tessera::server {

/// Who somebody is, and the certificate (PEM) that says so.
struct Visitor {
  Caller caller;
  std::string certificate;
};

/// Name by which the open pages and connections of one member are counted; empty where nobody logs in.
std::string name_of_member(const Visitor& who);

/// Login tokens, which are good for one login each, and the sessions that begin with one. Of secrets, digests
/// are kept, in memory: a restart ends all sessions. Thread-safe. Time is given by the caller.
class Logins {
 public:
  using Time = std::chrono::steady_clock::time_point;

  static constexpr std::chrono::hours kLongestToken{24};
  static constexpr std::chrono::hours kSession{12};
  static constexpr std::size_t kMost = 1'000;          // tokens, and sessions
  static constexpr std::size_t kMostOfOneCaller = 20;  // the oldest makes room for the next
  static constexpr int kSecretDigits = 32;             // 128 bits

  /// A secret that lets its holder in once, as `who`, until `now + life`. InvalidArgument for a life that is
  /// not within the bound above, ResourceExhausted when there are too many.
  absl::StatusOr<std::string> make_token(const Visitor& who, std::chrono::seconds life, Time now);
  /// The secret of a new session. PermissionDenied for a token that is not valid, ResourceExhausted when
  /// there are too many sessions. Guesses are not counted: nobody guesses 128 bits, and whoever tries keeps
  /// nobody out.
  absl::StatusOr<std::string> begin(const std::string& token, Time now);
  /// Whose session this is; none where it is not one, or is over.
  std::optional<Visitor> find(const std::string& session, Time now);
  void end(const std::string& session);

 private:
  struct Entry {
    Visitor who;
    Time until;
  };
  using Entries = std::map<std::string, Entry>;  // key: digest of the secret

  /// The secret of a new entry, which makes room for itself among those of its caller. ResourceExhausted.
  static absl::StatusOr<std::string> add(Entries& entries, const Visitor& who, Time until, Time now);

  std::mutex mutex_;
  Entries tokens_, sessions_;
};

}  // namespace tessera::server
