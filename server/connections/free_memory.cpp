#include "connections/free_memory.h"

#include <malloc.h>

#include <cstddef>

namespace tessera::server {
namespace {

constexpr std::size_t kMostFreeBytes = std::size_t{64} << 20;

}  // namespace

void trim_free_memory() {
#ifdef __GLIBC__
  if (::mallinfo2().fordblks > kMostFreeBytes) ::malloc_trim(0);
#endif
}

}  // namespace tessera::server
