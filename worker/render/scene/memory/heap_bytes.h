// Bytes that a value holds on the heap: what its arrays, strings and pointers have allocated, and what their
// elements have, all the way down.
#pragma once

#include <cstddef>
#include <memory>
#include <set>
#include <string>
#include <tuple>
#include <type_traits>
#include <vector>

namespace tessera::render {

/// Adds up values. What several of them share counts once.
class HeapBytes {
 public:
  std::size_t total() const { return total_; }

  /// Plain values, views and pointers that own nothing hold nothing. Of a struct with arrays, members() gives
  /// the members (table_members.h); there is none for a struct that nobody has listed, so that it does not
  /// compile.
  template <class T>
  void add(const T& value) {
    if constexpr (std::is_array_v<T>) {
      for (const auto& element : value) add(element);
    } else if constexpr (!std::is_trivially_copyable_v<T>) {
      std::apply([&](const auto&... member) { (add(member), ...); }, members(value));
    }
  }
  template <class T, class Allocator>
  void add(const std::vector<T, Allocator>& values) {
    total_ += values.capacity() * sizeof(T);
    if constexpr (!std::is_trivially_copyable_v<T>) {
      for (const T& value : values) add(value);
    }
  }
  void add(const std::string& text) {
    constexpr std::size_t kWithin =
        15;  // characters that a string of the standard library has room for itself
    if (text.capacity() > kWithin) total_ += text.capacity() + 1;
  }
  template <class T>
  void add(const std::shared_ptr<T>& shared) {
    if (shared == nullptr || !shared_.insert(shared.get()).second) return;
    total_ += sizeof(T);
    add(*shared);
  }

 private:
  std::size_t total_ = 0;
  std::set<const void*> shared_;
};

}  // namespace tessera::render
