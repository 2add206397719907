// main() of test programs that are compiled for one kernel ISA: skipped where the processor lacks it. Compiled with that ISA's
// flags like the rest, so nothing but this check may run first.
#include <gtest/gtest.h>

#include <cstdio>
#include <string_view>

#define TESSERA_STRING2(x) #x
#define TESSERA_STRING(x) TESSERA_STRING2(x)

namespace {

bool processor_has(std::string_view isa) {
#if defined(__x86_64__)
  if (isa == "avx512") return __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl");
  if (isa == "avx2") return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
#endif
  return isa == "neon";
}

}  // namespace

int main(int argc, char** argv) {
  if (!processor_has(TESSERA_STRING(TESSERA_ISA))) {
    std::puts("skipped: this processor has no " TESSERA_STRING(TESSERA_ISA));
    return 77;
  }
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
