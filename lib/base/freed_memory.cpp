#include "base/freed_memory.h"

#include <malloc.h>

namespace tessera::base {

void keep_freed_memory() {
#ifdef __GLIBC__
  constexpr int kLargestKept = 8 << 20, kMostKept = 16 << 20;  // bytes
  ::mallopt(M_MMAP_THRESHOLD, kLargestKept);
  ::mallopt(M_TRIM_THRESHOLD, kMostKept);
#endif
}

}  // namespace tessera::base
