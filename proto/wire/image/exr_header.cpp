#include <cstdint>
#include <cstring>

#include "wire/image/readers.h"

namespace tessera::wire {
namespace {

/// Removes a string and the zero behind it; false where there is none.
bool take_string(std::string_view& bytes, std::string_view& text) {
  const std::size_t end = bytes.find('\0');
  if (end == std::string_view::npos) return false;
  text = bytes.substr(0, end);
  bytes.remove_prefix(end + 1);
  return true;
}

}  // namespace

bool is_plausible_exr(std::string_view blob) {
  constexpr std::size_t kMarkAndVersion = 8;
  constexpr std::uint32_t kMultiPart = 0x1000;
  if (blob.size() < kMarkAndVersion) return false;
  std::uint32_t version;
  std::memcpy(&version, blob.data() + 4, sizeof(version));
  blob.remove_prefix(kMarkAndVersion);
  std::size_t attributes = 0;  // of this part
  for (std::string_view name, type; take_string(blob, name);) {
    if (name.empty()) {
      // The end of a header; of a file of several parts, an empty header is the last.
      if ((version & kMultiPart) == 0 || attributes == 0) return true;
      attributes = 0;
      continue;
    }
    std::int32_t size;
    if (!take_string(blob, type) || blob.size() < sizeof(size)) return false;
    std::memcpy(&size, blob.data(), sizeof(size));
    blob.remove_prefix(sizeof(size));
    if (size < 0 || static_cast<std::size_t>(size) > blob.size()) return false;
    blob.remove_prefix(static_cast<std::size_t>(size));
    ++attributes;
  }
  return false;
}

}  // namespace tessera::wire
