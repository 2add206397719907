// Arrays that the kernels read here and there.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <new>
#include <vector>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace tessera::render {

/// Gives arrays from 2 MiB on huge pages where the system has them: a table that is read at random misses the
/// cache of page translations otherwise, and in a virtual machine each miss is two walks. 64 bytes beyond the
/// end may be read: a row of a few elements may begin at the last one.
template <class T>
struct BigArrayAllocator {
  using value_type = T;

  BigArrayAllocator() = default;
  template <class U>
  BigArrayAllocator(const BigArrayAllocator<U>&) {}

  T* allocate(std::size_t n) {
    constexpr std::size_t kReadable = 64, kHugePage = std::size_t{1} << 21;
    if (n > (std::size_t{1} << 46) / sizeof(T)) throw std::bad_alloc();
    const std::size_t needed = n * sizeof(T) + kReadable;
    const std::size_t alignment = needed >= kHugePage ? kHugePage : kReadable;
    const std::size_t bytes = (needed + alignment - 1) / alignment * alignment;
    void* memory = std::aligned_alloc(alignment, bytes);
    if (!memory) throw std::bad_alloc();
#ifdef __linux__
    if (alignment == kHugePage) madvise(memory, bytes, MADV_HUGEPAGE);  // a refusal does no harm
#endif
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, std::size_t) { std::free(memory); }

  template <class U>
  bool operator==(const BigArrayAllocator<U>&) const {
    return true;
  }
};

template <class T>
using BigArray = std::vector<T, BigArrayAllocator<T>>;

}  // namespace tessera::render
