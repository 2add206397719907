#include "tls/expelled.h"

#include <algorithm>
#include <fstream>
#include <sstream>

#include "absl/strings/str_cat.h"
#include "base/private_file.h"
#include "net/x509.h"
#include "tls/authority.h"
#include "tls/unix_time.h"

namespace tessera::server {
namespace {

bool is_name(std::string_view name) {
  const auto is_plain = [](char c) { return c > ' ' && c != '\x7f'; };
  return !name.empty() && name.size() <= Expelled::kLongestName &&
         std::all_of(name.begin(), name.end(), is_plain);
}

}  // namespace

std::optional<std::chrono::system_clock::time_point> time_made(std::string_view certificate_pem) {
  const net::Certificate certificate = net::certificate_from_pem(certificate_pem);
  const auto begin = certificate == nullptr ? std::nullopt : net::begin_of(certificate.get());
  if (!begin) return std::nullopt;
  return *begin + kClockSlack;  // they begin a while before
}

absl::Status check_member_name(std::string_view name) {
  if (is_name(name)) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat("no certificate has this name: 1 to ",
                                                 Expelled::kLongestName,
                                                 " characters without spaces were expected"));
}

absl::StatusOr<std::unique_ptr<Expelled>> Expelled::open(std::filesystem::path file) {
  std::unique_ptr<Expelled> expelled{new Expelled{std::move(file)}};
  if (absl::Status status = expelled->read(); !status.ok()) return status;
  return expelled;
}

absl::Status Expelled::read() {
  if (file_.empty() || !std::filesystem::exists(file_)) return absl::OkStatus();
  std::ifstream in{file_};
  if (!in) return absl::UnavailableError(absl::StrCat(file_.string(), " cannot be read"));
  for (std::string line; std::getline(in, line);) {
    std::istringstream words{line};
    std::string role_name, name, more;
    std::int64_t seconds = 0;
    words >> role_name >> name >> seconds;
    const std::optional<Role> role = role_of_name(role_name);
    if (!words || !role || !is_name(name) || words >> more) {
      return absl::DataLossError(
          absl::StrCat(file_.string(), ": \"", line, "\" is not: role, name, seconds since 1970"));
    }
    members_[{*role, name}] = Time{std::chrono::seconds{seconds}};
  }
  return absl::OkStatus();
}

absl::Status Expelled::write(const Members& members) const {
  if (file_.empty()) return absl::OkStatus();
  std::string text;
  for (const auto& [member, since] : members) {
    absl::StrAppend(&text, to_string(member.first), " ", member.second, " ", unix_seconds(since), "\n");
  }
  return base::replace_file(file_, 0600, text);
}

absl::Status Expelled::expel(Role role, const std::string& name, Time now) {
  if (absl::Status status = check_member_name(name); !status.ok()) return status;
  const std::lock_guard lock{mutex_};
  Members members = members_;
  Time& since = members[{role, name}];
  since = std::max(since, now);  // nobody comes back because a clock was set back
  if (members.size() > kMostNames) {
    return absl::ResourceExhaustedError(
        "too many are expelled already; a new authority makes all certificates void");
  }
  if (absl::Status status = write(members); !status.ok()) return status;
  members_ = std::move(members);
  return absl::OkStatus();
}

absl::Status Expelled::readmit(Role role, const std::string& name) {
  const std::lock_guard lock{mutex_};
  Members members = members_;
  if (members.erase({role, name}) == 0) {
    return absl::NotFoundError(absl::StrCat(to_string(role), " '", name, "' is not expelled"));
  }
  if (absl::Status status = write(members); !status.ok()) return status;
  members_ = std::move(members);
  return absl::OkStatus();
}

bool Expelled::refuses(Role role, const std::string& name, std::string_view certificate_pem) const {
  Time since;
  {
    const std::lock_guard lock{mutex_};
    const auto found = members_.find({role, name});
    if (found == members_.end()) return false;
    since = found->second;
  }
  const std::optional<Time> made = time_made(certificate_pem);
  return !made || unix_seconds(*made) <= unix_seconds(since);
}

}  // namespace tessera::server
