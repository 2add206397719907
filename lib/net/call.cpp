#include "net/call.h"

namespace tessera::net {

StallGuard::StallGuard(grpc::ClientContext& context, std::chrono::milliseconds limit)
    : thread_([this, &context, limit](std::stop_token stop) { watch(context, limit, stop); }) {}

void StallGuard::progress() {
  {
    std::lock_guard lock{mutex_};
    ++messages_;
  }
  wake_.notify_one();
}

bool StallGuard::stalled() {
  std::lock_guard lock{mutex_};
  return stalled_;
}

void StallGuard::watch(grpc::ClientContext& context, std::chrono::milliseconds limit, std::stop_token stop) {
  std::unique_lock lock{mutex_};
  while (!stop.stop_requested()) {
    const std::uint64_t seen = messages_;
    const bool moved = wake_.wait_for(lock, stop, limit, [&] { return messages_ != seen; });
    if (moved || stop.stop_requested()) continue;
    stalled_ = true;
    context.TryCancel();
    return;
  }
}

}  // namespace tessera::net
