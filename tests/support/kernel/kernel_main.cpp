// main() of test programs that are compiled for one kernel ISA: skipped where the processor lacks it.
// Compiled with that ISA's flags like the rest, so nothing but processor_has(), which is compiled for
// every processor, may run first.
#include <gtest/gtest.h>

#include <cstdio>
#include <string>

#include "render/core/processor.h"
#include "support/run_tests.h"

#define TESSERA_STRING2(x) #x
#define TESSERA_STRING(x) TESSERA_STRING2(x)

int main(int argc, char** argv) {
  if (!tessera::render::processor_has(TESSERA_STRING(TESSERA_ISA))) {
    std::puts("skipped: this processor has no " TESSERA_STRING(TESSERA_ISA));
    tessera::test::note_skip(std::string(argv[0]) + ": this processor has no " TESSERA_STRING(TESSERA_ISA));
    return tessera::test::kSkipped;
  }
  testing::InitGoogleTest(&argc, argv);
  return tessera::test::run_tests(argc, argv);
}
