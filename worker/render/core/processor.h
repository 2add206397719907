// Abilities of this machine's processor. Compiled for every processor, unlike the kernels and their tests,
// and without headers of C++'s library: functions of those may be linked in the form of a kernel's ISA.
#pragma once

namespace tessera::render {

/// Whether the processor has all that kernels of an ISA ("avx512", "avx2", "neon") are compiled for.
bool processor_has(const char* isa);

}  // namespace tessera::render
