#include "render/core/processor.h"

namespace tessera::render {

bool processor_has(std::string_view isa) {
#if defined(__x86_64__)
  __builtin_cpu_init();  // tests ask before main()
  if (isa == "avx512") {
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
           __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl") &&
           __builtin_cpu_supports("avx512cd");
  }
  if (isa == "avx2") {
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2");
  }
  return false;
#else
  return isa == "neon";
#endif
}

}  // namespace tessera::render
