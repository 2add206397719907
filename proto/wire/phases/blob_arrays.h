// Arrays one after the other in the bytes of a blob, each after its length.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace tessera::wire {

/// Begins an array of so many values, whose bytes follow.
inline void put_count(std::uint64_t count, std::string& blob) {
  blob.append(reinterpret_cast<const char*>(&count), sizeof(count));
}

/// `T` has no padding, so that equal values are equal bytes.
template <class T>
void put_array(const std::vector<T>& values, std::string& blob) {
  static_assert(std::is_trivially_copyable_v<T>);
  put_count(values.size(), blob);
  blob.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
}

/// Finds the bytes of the array of `T` at the front of `blob`, and takes it away there. False where it is cut
/// off.
template <class T>
bool take_bytes(std::string_view& blob, std::string_view& bytes) {
  static_assert(std::is_trivially_copyable_v<T>);
  std::uint64_t count = 0;
  if (blob.size() < sizeof(count)) return false;
  std::memcpy(&count, blob.data(), sizeof(count));
  blob.remove_prefix(sizeof(count));
  if (count > blob.size() / sizeof(T)) return false;
  bytes = blob.substr(0, count * sizeof(T));
  blob.remove_prefix(bytes.size());
  return true;
}

/// Whether all values of an array's bytes satisfy `holds`, which is asked in their order until one does not.
template <class T, class F>
bool all_in_bytes(std::string_view bytes, F&& holds) {
  static_assert(std::is_trivially_copyable_v<T>);
  for (; !bytes.empty(); bytes.remove_prefix(sizeof(T))) {
    T value;
    std::memcpy(static_cast<void*>(&value), bytes.data(), sizeof(T));
    if (!holds(value)) return false;
  }
  return true;
}

template <class T>
void append_values(std::string_view bytes, std::vector<T>& values) {
  const std::size_t before = values.size();
  values.resize(before + bytes.size() / sizeof(T));
  if (!bytes.empty()) std::memcpy(static_cast<void*>(values.data() + before), bytes.data(), bytes.size());
}

/// Appends the array at the front of `blob`, and takes it away there. False where it is cut off.
template <class T>
bool take_array(std::string_view& blob, std::vector<T>& values) {
  std::string_view bytes;
  if (!take_bytes<T>(blob, bytes)) return false;
  append_values(bytes, values);
  return true;
}

}  // namespace tessera::wire
