// Independent pieces of work on a bounded number of threads.
#pragma once

#include <cstddef>
#include <functional>

namespace tessera::client {

/// Calls `work(i)` for every i in [0, count), on at most `threads` threads (0: one a core), in no particular
/// order. Returns when all are done.
void parallel_for(std::size_t count, int threads, const std::function<void(std::size_t)>& work);

}  // namespace tessera::client
