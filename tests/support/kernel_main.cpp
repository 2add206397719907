// main() of test programs that are compiled for one kernel ISA: skipped where the processor lacks it.
// Compiled with that ISA's flags like the rest, so nothing but this check may run first.
#include <gtest/gtest.h>

#include <cstdio>
#include <string>
#include <string_view>

#include "support/run_tests.h"

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
    tessera::test::note_skip(std::string(argv[0]) + ": this processor has no " TESSERA_STRING(TESSERA_ISA));
    return tessera::test::kSkipped;
  }
  testing::InitGoogleTest(&argc, argv);
  return tessera::test::run_tests();
}
