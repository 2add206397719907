// Rows of a picture, shared among threads.
#pragma once

#include <atomic>
#include <cstdint>
#include <thread>
#include <vector>

namespace tessera::light_field {

/// Calls work(y) for each row, by so many threads, and returns when all are done.
template <class Work>
void for_each_row(std::uint32_t rows, int threads, const Work& work) {
  std::atomic<std::uint32_t> next = 0;
  const auto run = [&] {
    for (std::uint32_t y = next++; y < rows; y = next++) work(y);
  };
  std::vector<std::jthread> helpers;
  for (int i = 1; i < threads; ++i) helpers.emplace_back(run);
  run();
}

}  // namespace tessera::light_field
