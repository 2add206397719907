#include "import/input/include_stack.h"

#include <algorithm>
#include <utility>

#include "import/input/concat.h"

namespace tessera::client {

std::string IncludeStack::enter(const std::filesystem::path& path) {
  std::error_code error;
  std::string canonical = std::filesystem::weakly_canonical(path, error).string();
  if (std::ranges::find(open_, canonical) != open_.end()) return concat(path.string(), " includes itself");
  if (open_.size() >= deepest_) return concat("files are included more than ", deepest_ - 1, " deep");
  if (++files_ > kMostFiles) return concat("more than ", kMostFiles, " files are included");
  open_.push_back(std::move(canonical));
  return "";
}

std::string IncludeStack::count_bytes(std::uint64_t bytes) {
  if (read_.insert(open_.back()).second) return "";
  bytes_again_ += bytes;
  if (bytes_again_ <= kMostRereadBytes) return "";
  return concat("files that are included again and again come to more than ", kMostRereadBytes, " bytes");
}

}  // namespace tessera::client
