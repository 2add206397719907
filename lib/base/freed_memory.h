#pragma once

namespace tessera::base {

/// Lets the C library keep freed memory for what is allocated next, up to 16 MB for each thread. Rendering
/// asks for the same few MB again for every tile; by default, glibc gives pieces of that size back, and the
/// system takes longer to give out fresh pages than a tile of few samples takes to be filtered
/// [docs/decisions/0061-kernel-variants.md]. For programs that render, before they start threads.
void keep_freed_memory();

}  // namespace tessera::base
