#include "base/available_memory.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <optional>

namespace tessera::base {
namespace {

/// Available bytes of the machine.
std::optional<std::uint64_t> of_machine(const std::string& root) {
  std::ifstream in(root + "/proc/meminfo");
  std::string name, rest;
  for (std::uint64_t kibibytes = 0; in >> name >> kibibytes; std::getline(in, rest)) {
    if (name == "MemAvailable:") return kibibytes * 1024;
  }
  return std::nullopt;
}

/// The number that a file begins with; none where it is "max", or not there.
std::optional<std::uint64_t> number_in(const std::filesystem::path& path) {
  std::ifstream in(path);
  std::uint64_t number = 0;
  if (in >> number) return number;
  return std::nullopt;
}

/// The path of the process's group below the groups' folder.
std::string group_of_process(const std::string& root) {
  std::ifstream in(root + "/proc/self/cgroup");
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("0::/")) return line.substr(4);
  }
  return "";
}

}  // namespace

std::uint64_t available_memory(const std::string& root) {
  std::uint64_t bytes = of_machine(root).value_or(UINT64_MAX);
  const std::filesystem::path groups = root + "/sys/fs/cgroup";
  for (std::filesystem::path group = group_of_process(root);; group = group.parent_path()) {
    const auto most = number_in(groups / group / "memory.max"),
               now = number_in(groups / group / "memory.current");
    if (most && now) bytes = std::min(bytes, *most - std::min(*most, *now));
    if (group.empty()) return bytes;
  }
}

}  // namespace tessera::base
