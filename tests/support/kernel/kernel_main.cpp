// main() of test programs that are compiled for one kernel ISA: skipped where the processor lacks it.
// Compiled with that ISA's flags like the rest, so nothing but processor_has(), which is compiled for
// every processor, may run first: not even constants of the tests, which are made before main().
#include <gtest/gtest.h>

#include <unistd.h>

#include <cstdio>
#include <string>

#include "render/core/processor.h"
#include "support/run_tests.h"

#define TESSERA_STRING2(x) #x
#define TESSERA_STRING(x) TESSERA_STRING2(x)

namespace {

/// Runs before all constants without a priority of their own.
__attribute__((constructor(101))) void skip_where_the_isa_is_missing(int, char** argv, char**) {
  if (tessera::render::processor_has(TESSERA_STRING(TESSERA_ISA))) return;
  std::puts("skipped: this processor has no " TESSERA_STRING(TESSERA_ISA));
  std::fflush(stdout);
  tessera::test::note_skip(std::string(argv[0]) + ": this processor has no " TESSERA_STRING(TESSERA_ISA));
  _exit(tessera::test::kSkipped);
}

}  // namespace

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  return tessera::test::run_tests(argc, argv);
}
