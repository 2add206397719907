// Numbers out of files that have them as memory does.
#pragma once

#include <bit>
#include <cstring>
#include <string_view>

namespace tessera::client {

static_assert(std::endian::native == std::endian::little, "files are little endian, and so is memory");

/// Returns the number at `offset`; the bytes must be there.
template <typename T>
T load_bytes(std::string_view bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof(T));
  return value;
}

}  // namespace tessera::client
