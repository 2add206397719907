#include "agent/link/session.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

#include "net/backoff.h"
#include "net/status.h"

namespace tessera::agent {
namespace {

constexpr std::chrono::milliseconds kShortestHeartbeat{50};
constexpr std::chrono::milliseconds kReconnectCap{2000};

std::chrono::milliseconds interval_of(const google::protobuf::Duration& duration) {
  const std::chrono::milliseconds wanted =
      std::chrono::seconds{duration.seconds()} + std::chrono::milliseconds{duration.nanos() / 1'000'000};
  return std::max(kShortestHeartbeat, wanted);
}

}  // namespace

Session::Session(base::Clock& clock, CoordinatorLink& link, v1::RegisterRequest request, Introduce introduce)
    : clock_(clock), link_(link), request_(std::move(request)), introduce_(std::move(introduce)) {}

absl::StatusOr<std::string> Session::worker_id(std::stop_token stop) {
  std::unique_lock lock{mutex_};
  changed_.wait(lock, stop, [this] { return !registering_; });
  if (stop.stop_requested()) return absl::CancelledError("stopped while registering");
  if (!refused_.ok()) return refused_;
  if (!worker_id_.empty()) return worker_id_;

  // This thread registers; the others wait for what comes of it.
  registering_ = true;
  const bool registered_before = registered_before_;
  lock.unlock();
  const absl::StatusOr<v1::RegisterResponse> response = register_until_heard(registered_before, stop);
  if (response.ok()) introduce_(response->worker_id(), stop);
  lock.lock();
  registering_ = false;
  changed_.notify_all();  // nobody looks before the lock is free
  if (!response.ok()) {
    if (!absl::IsCancelled(response.status())) refused_ = response.status();
    return response.status();
  }
  registered_before_ = true;
  worker_id_ = response->worker_id();
  heartbeat_interval_ = interval_of(response->heartbeat_interval());
  spdlog::info("registered with {} as {} (coordinator start {})", link_.address(), worker_id_,
               response->epoch());
  return worker_id_;
}

void Session::set_heartbeat_interval(const google::protobuf::Duration& interval) {
  const std::lock_guard lock{mutex_};
  heartbeat_interval_ = interval_of(interval);
}

absl::StatusOr<v1::RegisterResponse> Session::register_until_heard(bool registered_before,
                                                                   std::stop_token stop) {
  net::Backoff backoff{std::chrono::milliseconds{100}, kReconnectCap};
  std::string last_message;
  while (true) {
    absl::StatusOr<v1::RegisterResponse> response = link_.register_worker(request_, stop);
    if (response.ok()) return response;
    if (stop.stop_requested()) return absl::CancelledError("stopped while registering");
    // Whoever once took this worker is a coordinator, whatever else may be answered since.
    const bool final =
        registered_before ? net::is_refusal(response.status()) : !net::is_transient(response.status());
    if (final) return response.status();
    // The same reason again is worth no second line.
    if (std::string message = response.status().ToString(); message != last_message) {
      spdlog::warn("{}; trying again", message);
      last_message = std::move(message);
    }
    if (!link_.wait(backoff, stop)) return absl::CancelledError("stopped while registering");
  }
}

void Session::lost(const std::string& worker_id) {
  std::lock_guard lock{mutex_};
  if (worker_id_ != worker_id) return;  // somebody noticed before
  spdlog::warn("{} no longer knows {}; registering again", link_.address(), worker_id);
  worker_id_.clear();
  changed_.notify_all();
}

std::string Session::current() const {
  std::lock_guard lock{mutex_};
  return worker_id_;
}

absl::StatusOr<std::string> Session::wait_for_beat(const std::string& known, std::stop_token stop) {
  {
    std::unique_lock lock{mutex_};
    const auto due = [&] { return worker_id_ != known || last_beat_ + heartbeat_interval_ <= clock_.now(); };
    // Again where a heartbeat went out early meanwhile.
    while (!due() && !stop.stop_requested())
      changed_.wait_until(lock, stop, last_beat_ + heartbeat_interval_, due);
    last_beat_ = clock_.now();
  }
  return worker_id(stop);
}

bool Session::beat_early() {
  const std::lock_guard lock{mutex_};
  const base::Clock::TimePoint now = clock_.now();
  if (last_beat_ + heartbeat_interval_ / 2 > now) return false;
  last_beat_ = now;
  return true;
}

void Session::beat_at_once() {
  const std::lock_guard lock{mutex_};
  last_beat_ = {};
  changed_.notify_all();
}

}  // namespace tessera::agent
