#include "render/scene/values/parallel.h"

#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "render/core/stopped.h"

namespace tessera::render {

namespace {

/// On a thread of its own nobody would catch what is thrown.
template <class Work>
absl::Status without_exceptions(const Work& work) {
  try {
    return work();
  } catch (const Stopped&) {
    return absl::CancelledError("stopped");
  } catch (const std::exception& error) {  // out of memory, above all
    return absl::ResourceExhaustedError(error.what());
  }
}

}  // namespace

absl::Status parallel_for(std::size_t n, int threads, const std::function<absl::Status(std::size_t)>& f) {
  std::atomic<std::size_t> next{0};
  std::mutex mutex;
  absl::Status first_error;
  const auto work = [&] {
    for (std::size_t i; (i = next.fetch_add(1)) < n;) {
      const absl::Status status = without_exceptions([&] { return f(i); });
      if (status.ok()) continue;
      std::lock_guard lock(mutex);
      if (first_error.ok()) first_error = status;
      next = n;
    }
  };
  std::vector<std::jthread> workers;
  for (int i = 1; i < threads && static_cast<std::size_t>(i) < n; ++i) workers.emplace_back(work);
  work();
  workers.clear();  // joins
  return first_error;
}

}  // namespace tessera::render
