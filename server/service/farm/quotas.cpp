#include "service/farm/quotas.h"

#include <charconv>
#include <cmath>
#include <system_error>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace tessera::server {
namespace {

template <class Number>
bool read_number(std::string_view text, Number& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc{} && end == text.data() + text.size();
}

/// `read` takes the number after the user's name and "=", where there are these.
template <class Number, class Read>
absl::Status read_per_user(const std::string& text, PerUser<Number>& quota, const char* expected, Read read) {
  const std::size_t sign = text.find('=');
  const std::string user = sign == std::string::npos ? "" : text.substr(0, sign);
  Number number{};
  if (sign == 0 || !read(std::string_view{text}.substr(sign == std::string::npos ? 0 : sign + 1), number)) {
    return absl::InvalidArgumentError(
        absl::StrCat("\"", text, "\" is neither ", expected, " nor USER=", expected));
  }
  (user.empty() ? quota.of_all : quota.of_some[user]) = number;
  return absl::OkStatus();
}

absl::Status too_much(const std::string& user, const std::string& have, const std::string& most,
                      const char* option, const char* remedy) {
  return absl::ResourceExhaustedError(absl::StrCat("'", user, "' would have ", have, "; the quota is ", most,
                                                   " (tessera-server ", option, "): ", remedy,
                                                   ", or ask an administrator for more"));
}

std::string gigabytes(std::uint64_t bytes) {
  return absl::StrFormat("%.3f", 1e-9 * static_cast<double>(bytes));
}

}  // namespace

absl::Status read_quota(const std::string& text, PerUser<std::int32_t>& quota) {
  return read_per_user(text, quota, "a whole number", &read_number<std::int32_t>);
}

absl::Status read_quota(const std::string& text, PerUser<std::uint64_t>& quota) {
  return read_per_user(text, quota, "a whole number", &read_number<std::uint64_t>);
}

absl::Status read_gigabytes(const std::string& text, PerUser<std::uint64_t>& quota) {
  return read_per_user(text, quota, "a number of GB", [](std::string_view word, std::uint64_t& bytes) {
    constexpr double kMost = 1e9;
    double number = 0;
    if (!read_number(word, number) || !(number >= 0) || number > kMost) return false;
    bytes = static_cast<std::uint64_t>(std::llround(number * 1e9));
    return true;
  });
}

absl::Status Quotas::check_priority(const std::string& user, std::int32_t asked) const {
  const std::int32_t most = priority.of(user);
  if (asked <= most) return absl::OkStatus();
  return absl::PermissionDeniedError(absl::StrCat(
      "priority ", asked, " is higher than '", user, "' may ask for, which is ", most,
      " (tessera-server --max-priority): ask for less, or ask an administrator, who may give it ",
      "to the job (tessera priority) or raise the bound"));
}

absl::Status Quotas::check_share(const std::string& user, const UserShare& share) const {
  if (share.open_jobs > open_jobs.of(user)) {
    return too_much(user, absl::StrCat(share.open_jobs, " jobs that are not over"),
                    absl::StrCat(open_jobs.of(user)), "--max-open-jobs", "try again when some are done");
  }
  if (share.units > units.of(user)) {
    return too_much(user,
                    absl::StrCat(share.units, " units of jobs that are open, incomplete or have just ended"),
                    absl::StrCat(units.of(user)), "--max-open-units",
                    "try again when some are done, delete incomplete ones, or take larger tiles or more "
                    "samples a unit");
  }
  return check_blob_bytes(user, share.blob_bytes);
}

absl::Status Quotas::check_blob_bytes(const std::string& user, std::uint64_t bytes) const {
  if (bytes <= blob_bytes.of(user)) return absl::OkStatus();
  return too_much(user, absl::StrCat(gigabytes(bytes), " GB of scenes and what they refer to"),
                  absl::StrCat(gigabytes(blob_bytes.of(user)), " GB"), "--max-blobs",
                  "delete old jobs, or try again when they are deleted");
}

}  // namespace tessera::server
