// Work that is done once, by whichever threads come for its result.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <exception>
#include <functional>
#include <mutex>
#include <stop_token>
#include <utility>
#include <vector>

#include "render/accel/ray_query.h"

namespace tessera::render::TESSERA_ISA {

/// Stages of pieces: those of a stage may be done at the same time, once all stages before are.
class SharedWork {
 public:
  struct Stage {
    std::function<std::size_t()> pieces;                               // asked when its turn comes
    std::function<void(std::size_t piece, const RayQuery& rays)> run;  // `rays` are those of who runs it
  };

  explicit SharedWork(std::vector<Stage> stages) : stages_(std::move(stages)) { enter_stage(); }

  /// Takes pieces as long as there are any; returns when all work is done, or false when stopped before. An
  /// exception of a piece goes to all who come.
  bool help(const RayQuery& rays, std::stop_token stop) {
    std::unique_lock lock(mutex_);
    for (;;) {
      if (failure_) std::rethrow_exception(failure_);
      if (stage_ == stages_.size()) return true;
      if (stop.stop_requested()) return false;
      if (next_ == pieces_) {
        // Whoever has the last pieces ends them, stopped or not.
        changed_.wait(lock);
        continue;
      }
      run_piece(lock, rays);
    }
  }

 private:
  void run_piece(std::unique_lock<std::mutex>& lock, const RayQuery& rays) {
    const std::size_t piece = next_++;
    const Stage& stage = stages_[stage_];
    lock.unlock();
    std::exception_ptr failure;
    try {
      stage.run(piece, rays);
    } catch (...) {
      failure = std::current_exception();
    }
    lock.lock();
    if (failure) failure_ = failure;
    if (++done_ == pieces_ && !failure_) {
      ++stage_;
      enter_stage();
    }
    if (done_ == 0 || failure_) changed_.notify_all();
  }

  /// Goes on to the next stage that has any pieces.
  void enter_stage() {
    next_ = done_ = pieces_ = 0;
    for (; stage_ < stages_.size() && (pieces_ = stages_[stage_].pieces()) == 0; ++stage_) {
    }
  }

  const std::vector<Stage> stages_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::size_t stage_ = 0, next_ = 0, done_ = 0, pieces_ = 0;
  std::exception_ptr failure_;
};

}  // namespace tessera::render::TESSERA_ISA
