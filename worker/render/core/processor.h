// Abilities of this machine's processor. Compiled for every processor, unlike the kernels and their tests.
#pragma once

#include <string_view>

namespace tessera::render {

/// Whether the processor has all that kernels of an ISA ("avx512", "avx2", "neon") are compiled for.
bool processor_has(std::string_view isa);

}  // namespace tessera::render
