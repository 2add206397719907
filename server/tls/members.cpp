#include "tls/members.h"

#include <fcntl.h>
#include <unistd.h>

#include <fstream>
#include <optional>
#include <sstream>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "base/nearest_name.h"

namespace tessera::server {
namespace {

constexpr std::size_t kMostListed = 16;

/// One write of a whole line: two coordinators never share the file, and half a line after a crash is left
/// out.
void append_line(const std::filesystem::path& file, const std::string& line) {
  const int descriptor = ::open(file.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
  if (descriptor < 0) return;
  static_cast<void>(!::write(descriptor, line.data(), line.size()));
  ::close(descriptor);
}

}  // namespace

absl::StatusOr<std::unique_ptr<Members>> Members::open(std::filesystem::path file) {
  std::unique_ptr<Members> members{new Members{std::move(file)}};
  const std::filesystem::path& path = members->file_;
  if (path.empty() || !std::filesystem::exists(path)) return members;
  std::ifstream in{path};
  if (!in) return absl::UnavailableError(absl::StrCat(path.string(), " cannot be read"));
  for (std::string line; std::getline(in, line) && members->seen_.size() < kMost;) {
    std::istringstream words{line};
    std::string role_name, name;
    words >> role_name >> name;
    if (const std::optional<Role> role = role_of_name(role_name); role && !name.empty()) {
      members->seen_.emplace(*role, name);
    }
  }
  return members;
}

void Members::note(Role role, const std::string& name) {
  const std::lock_guard lock{mutex_};
  if (seen_.size() >= kMost || !seen_.emplace(role, name).second || file_.empty()) return;
  append_line(file_, absl::StrCat(to_string(role), " ", name, "\n"));
}

bool Members::has_seen(Role role, const std::string& name) const {
  const std::lock_guard lock{mutex_};
  return seen_.contains({role, name});
}

absl::Status Members::check_seen(Role role, const std::string& name) const {
  if (has_seen(role, name)) return absl::OkStatus();
  const std::lock_guard lock{mutex_};
  std::vector<std::string> names, joined;
  for (const auto& [other_role, other] : seen_) {
    if (other_role != role) continue;
    names.push_back(other);
    if (joined.size() < kMostListed && other.starts_with(name + "@")) joined.push_back(other);
  }
  return absl::NotFoundError(absl::StrCat(
      "no ", to_string(role), " with the name '", name, "' in its certificate has ", "called here",
      joined.empty() ? base::did_you_mean(name, names) : "; these have: " + absl::StrJoin(joined, ", ")));
}

}  // namespace tessera::server
