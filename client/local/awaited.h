// Answers of the coordinator of this process, waited for.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <utility>

#include "absl/status/status.h"
#include "base/clock.h"

namespace tessera::client {

/// Waits for what `done` of a call is called with, an absl::Status or StatusOr. Whoever calls keeps a copy of
/// `done`, so the answer may come when nobody waits any more.
template <class Result>
class Awaited {
 public:
  explicit Awaited(base::Clock& clock) : state_(std::make_shared<State>(clock)) {}

  auto done() const {
    return [state = state_](Result result) {
      {
        const std::lock_guard lock(state->mutex);
        state->result.emplace(std::move(result));
      }
      state->changed.notify_all();
    };
  }

  /// Cancelled when `stop` is requested before there is an answer.
  Result wait(const std::stop_token& stop) {
    std::unique_lock lock(state_->mutex);
    if (!state_->changed.wait(lock, stop, [this] { return state_->result.has_value(); }))
      return absl::CancelledError("the call was given up");
    return *std::move(state_->result);
  }

 private:
  struct State {
    explicit State(base::Clock& clock) : changed(clock) {}

    std::mutex mutex;
    base::Condition changed;
    std::optional<Result> result;
  };
  const std::shared_ptr<State> state_;
};

}  // namespace tessera::client
