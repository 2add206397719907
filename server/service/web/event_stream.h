// One stream of server-sent events [WHATWG HTML, 9.2].
#pragma once

#include <atomic>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>

#include "absl/strings/str_cat.h"

namespace tessera::server {

/// Bytes on their way to one browser. Thread-safe. Nothing is added while something waits (idle()), so a slow
/// reader holds one round of news and no more.
class EventStream {
 public:
  /// An event of that name; `data` has no line breaks.
  void push(std::string_view event, std::string_view data) {
    add(absl::StrCat("event: ", std::string(event), "\ndata: ", std::string(data), "\n\n"));
  }
  /// A line that browsers pass over: so a connection that is gone is noticed.
  void push_comment() { add(":\n\n"); }

  /// Whether all was taken.
  bool idle() const {
    const std::lock_guard lock(mutex_);
    return taken_ == bytes_.size();
  }
  /// No more will come.
  void close() {
    std::function<void()> wake;
    {
      const std::lock_guard lock(mutex_);
      closed_ = true;
      wake.swap(wake_);
    }
    if (wake) wake();
  }
  bool closed() const { return closed_; }

  // ---- for the server

  /// Up to `most` bytes; 0 where there are none yet, or the stream is closed. `park` is called before it is
  /// known to others that somebody waits, and `wake`, once, when there is more.
  std::size_t take(char* buffer, std::size_t most, const std::function<void()>& park,
                   std::function<void()> wake) {
    const std::lock_guard lock(mutex_);
    const std::size_t count = bytes_.copy(buffer, most, taken_);
    taken_ += count;
    if (taken_ == bytes_.size()) {
      bytes_.clear();
      taken_ = 0;
    }
    if (count == 0 && !closed_) {
      park();
      wake_ = std::move(wake);
    }
    return count;
  }
  /// Nobody listens any more, and nobody is to be woken.
  void abandon() {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    wake_ = nullptr;
  }

 private:
  void add(std::string text) {
    std::function<void()> wake;
    {
      const std::lock_guard lock(mutex_);
      bytes_ += text;
      wake.swap(wake_);
    }
    if (wake) wake();
  }

  mutable std::mutex mutex_;
  std::string bytes_;
  std::size_t taken_ = 0;
  std::function<void()> wake_;
  std::atomic<bool> closed_ = false;
};

}  // namespace tessera::server
