// Clocks for the stages of a batch. Two reads of the processor's counter a stage and batch cost nothing that
// can be measured; what goes on within shading is looked at in one batch of paths in 17 (a prime: no rhythm
// of tiles).
#pragma once

#include <bit>
#include <cstdint>

#include "render/core/wide.h"
#include "render/film/stage_times.h"

namespace tessera::render::TESSERA_ISA {

/// A counter that runs at a steady pace, of whatever unit.
TESSERA_INLINE std::uint64_t clock_ticks() {
#if defined(__x86_64__)
  return __builtin_ia32_rdtsc();
#else
  std::uint64_t ticks;
  asm volatile("mrs %0, cntvct_el0" : "=r"(ticks));
  return ticks;
#endif
}

/// Counts the time until its end as that of `stage`. Stages do not nest.
class StageTimer {
 public:
  StageTimer(StageTimes& times, Stage stage)
      : ticks_(times.stages[static_cast<std::size_t>(stage)]), start_(clock_ticks()) {}
  ~StageTimer() { ticks_ += clock_ticks() - start_; }
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;

 private:
  std::uint64_t& ticks_;
  const std::uint64_t start_;
};

/// Counts the time until its end as that of `stage`, within a StageTimer of another, which is not told.
class InnerStageTimer {
 public:
  InnerStageTimer(StageTimes& times, Stage stage, Stage around)
      : ticks_(times.stages[static_cast<std::size_t>(stage)]),
        around_(times.stages[static_cast<std::size_t>(around)]),
        start_(clock_ticks()) {}
  ~InnerStageTimer() {
    const std::uint64_t spent = clock_ticks() - start_;
    ticks_ += spent;
    around_ -= spent;  // modulo 2^64: what is around adds it when it ends
  }
  InnerStageTimer(const InnerStageTimer&) = delete;
  InnerStageTimer& operator=(const InnerStageTimer&) = delete;

 private:
  std::uint64_t& ticks_;
  std::uint64_t& around_;
  const std::uint64_t start_;
};

/// A stop watch for the parts of shading; does nothing in most batches.
class ShadingTimer {
 public:
  explicit ShadingTimer(StageTimes& times) : times_(times) {}

  /// Decides whether this batch is looked into.
  void begin_batch(std::size_t materials) {
    constexpr std::uint32_t kInterval = 17;
    static thread_local std::uint32_t batches = 0;
    on_ = batches++ % kInterval == 0;
    if (on_ && times_.materials.size() < materials) times_.materials.resize(materials);
  }
  /// Shading starts.
  TESSERA_INLINE void start() {
    if (on_) last_ = clock_ticks();
  }
  /// The time since the last call was spent on `part`.
  TESSERA_INLINE void lap(ShadingPart part) {
    if (!on_) return;
    const std::uint64_t now = clock_ticks(), spent = now - last_;
    times_.shading_parts[static_cast<std::size_t>(part)] += spent;
    if (part == ShadingPart::kMaterials) packet_material_time_ += spent;
    last_ = now;
  }
  /// The packet's time with materials was spent on these.
  void share(Int material, Mask lanes) {
    if (!on_) return;
    alignas(64) std::int32_t index[kWidth];
    material.store(index);
    const std::uint64_t each =
        any(lanes) ? packet_material_time_ / static_cast<std::uint64_t>(count(lanes)) : 0;
    for (std::uint32_t bits = lanes.bits(); bits != 0; bits &= bits - 1) {
      times_.materials[static_cast<std::size_t>(index[std::countr_zero(bits)])] += each;
    }
    packet_material_time_ = 0;
  }

 private:
  StageTimes& times_;
  bool on_ = false;
  std::uint64_t last_ = 0;
  std::uint64_t packet_material_time_ = 0;
};

}  // namespace tessera::render::TESSERA_ISA
