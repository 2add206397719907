// Memory that was freed and that the C library keeps.
#pragma once

namespace tessera::server {

/// Returns freed memory to the system where there is much of it: after a flood of requests, glibc keeps it
/// for ever. Takes milliseconds; to be called every few seconds.
void trim_free_memory();

}  // namespace tessera::server
