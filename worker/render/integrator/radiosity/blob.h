// Arrays one after the other in the bytes of a blob, each after its length.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace tessera::render::radiosity {

/// `T` has no padding, so that equal values are equal bytes.
template <class T>
void put_array(const std::vector<T>& values, std::string& blob) {
  static_assert(std::is_trivially_copyable_v<T>);
  const std::uint64_t count = values.size();
  blob.append(reinterpret_cast<const char*>(&count), sizeof(count));
  blob.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
}

/// Appends the array at the front of `blob`, and takes it away there. False where it is cut off.
template <class T>
bool take_array(std::string_view& blob, std::vector<T>& values) {
  static_assert(std::is_trivially_copyable_v<T>);
  std::uint64_t count = 0;
  if (blob.size() < sizeof(count)) return false;
  std::memcpy(&count, blob.data(), sizeof(count));
  blob.remove_prefix(sizeof(count));
  if (count > blob.size() / sizeof(T)) return false;
  const std::size_t before = values.size();
  values.resize(before + count);
  std::memcpy(static_cast<void*>(values.data() + before), blob.data(), count * sizeof(T));
  blob.remove_prefix(count * sizeof(T));
  return true;
}

}  // namespace tessera::render::radiosity
