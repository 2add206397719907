// Building the two halves of a tree at once.
#pragma once

#include <atomic>
#include <future>

namespace tessera::render {

/// Lends out threads that nobody uses. What is built does not depend on who gets one.
class Forks {
 public:
  explicit Forks(int threads) : spare_(threads - 1) {}

  /// f() and g(), at once where a thread is free. What either throws comes out.
  template <class F, class G>
  void both(F&& f, G&& g) {
    both(f, g, g);
  }
  /// f() and g() at once where a thread is free, else f() and then `alone`(), which need not keep apart from
  /// f what it makes.
  template <class F, class G, class Alone>
  void both(F&& f, G&& g, Alone&& alone) {
    if (spare_.fetch_sub(1) <= 0) {
      ++spare_;
      f();
      alone();
      return;
    }
    std::future<void> other = std::async(std::launch::async, g);
    try {
      f();
    } catch (...) {
      other.wait();
      ++spare_;
      throw;
    }
    other.wait();
    ++spare_;
    other.get();
  }

 private:
  std::atomic<int> spare_;
};

/// Below so many primitives a thread of its own costs more than it brings.
inline constexpr std::size_t kForkSize = 4096;

}  // namespace tessera::render
