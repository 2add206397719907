// Ends test programs that are compiled for one kernel ISA where the processor lacks it: exit code 77, which
// CTest counts as skipped. Runs before the constants of the tests are made, which happens before main().
//
// Every function of C++'s library that the tests use, too, may be linked in the form of their ISA, even
// std::string's: this file is compiled for every processor, and calls nothing but C's.
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "render/core/processor.h"

namespace {

/// Does what tessera::test::note_skip() does.
void note_skip(const char* program) {
  const char* const path = getenv("TESSERA_SKIPS");
  if (path == nullptr) return;
  const int file = open(path, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (file < 0) return;
  dprintf(file, "%s: this processor has no " TESSERA_TEST_ISA "\n", program);
  close(file);
}

/// Runs before all constants without a priority of their own.
__attribute__((constructor(101))) void skip_where_the_isa_is_missing(int, char** argv, char**) {
  if (tessera::render::processor_has(TESSERA_TEST_ISA)) return;
  puts("skipped: this processor has no " TESSERA_TEST_ISA);
  fflush(stdout);
  note_skip(argv[0]);
  _exit(77);
}

}  // namespace
