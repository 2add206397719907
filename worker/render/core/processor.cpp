#include "render/core/processor.h"

#include <cstring>

namespace tessera::render {

bool processor_has(const char* isa) {
#if defined(__x86_64__)
  __builtin_cpu_init();  // tests ask before main()
  if (std::strcmp(isa, "avx512") == 0) {
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
           __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl") &&
           __builtin_cpu_supports("avx512cd");
  }
  if (std::strcmp(isa, "avx2") == 0) {
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2");
  }
  return false;
#else
  return std::strcmp(isa, "neon") == 0;
#endif
}

}  // namespace tessera::render
