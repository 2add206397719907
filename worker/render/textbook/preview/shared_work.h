// Work that is done once, by whichever threads come for its result.
#pragma once

#include <algorithm>
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <mutex>
#include <numeric>
#include <stop_token>
#include <utility>
#include <vector>

#include "render/accel/ray_query.h"

namespace tessera::render::TESSERA_ISA {

/// Stages of pieces: those of a stage may be done at the same time, once all stages before are.
class SharedWork {
 public:
  struct Stage {
    std::size_t pieces;
    // `rays` are those of who runs it. A piece that throws may be run again.
    std::function<void(std::size_t piece, const RayQuery& rays)> run;
  };

  explicit SharedWork(std::vector<Stage> stages) : stages_(std::move(stages)) {
    for (const Stage& stage : stages_) order_.resize(std::max(order_.size(), stage.pieces));
    enter_stage();
  }

  /// Takes pieces as long as there are any; returns when all work is done, or false when stopped before. An
  /// exception of a piece goes to who ran it; the piece is there for the next who comes.
  bool help(const RayQuery& rays, std::stop_token stop) {
    std::unique_lock lock(mutex_);
    for (;;) {
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
    const std::size_t piece = order_[next_++];
    const Stage& stage = stages_[stage_];
    lock.unlock();
    try {
      stage.run(piece, rays);
    } catch (...) {
      lock.lock();
      order_[--next_] = piece;
      changed_.notify_all();
      throw;
    }
    lock.lock();
    if (++done_ < pieces_) return;
    ++stage_;
    enter_stage();
    changed_.notify_all();
  }

  /// Goes on to the next stage that has any pieces.
  void enter_stage() {
    next_ = done_ = pieces_ = 0;
    while (stage_ < stages_.size() && stages_[stage_].pieces == 0) ++stage_;
    if (stage_ == stages_.size()) return;
    pieces_ = stages_[stage_].pieces;
    std::iota(order_.begin(), order_.begin() + static_cast<std::ptrdiff_t>(pieces_), std::size_t{0});
  }

  const std::vector<Stage> stages_;
  std::mutex mutex_;
  std::condition_variable changed_;
  // The pieces of the stage at hand: those from next_ on in order_ are still to be taken.
  std::vector<std::size_t> order_;
  std::size_t stage_ = 0, next_ = 0, done_ = 0, pieces_ = 0;
};

}  // namespace tessera::render::TESSERA_ISA
