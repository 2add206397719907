// Subpaths in flight whose lanes stay together: sixteen neighbouring slots are a packet, and keep to it, so
// that both subpaths of a sample have their vertices in the same lane. Only rays are packed.
#pragma once

#include <cstdint>

#include "render/transport/vertex/partial_weights.h"
#include "render/transport/vertex/path_state.h"

namespace tessera::render::TESSERA_ISA {

/// Subpaths that a thread has in flight: so few that what is kept of them stays in its cache (measured:
/// docs/decisions/0029-bidirectional.md).
inline constexpr int kSubpaths = 128;
inline constexpr int kPackets = kSubpaths / kWidth;

class Frontier {
 public:
  /// Entries in the order of their slots, for rays.
  PathState paths;
  HitState hits;

  /// `count` paths are at entries 0, 1, ... of `paths`, in slots of the same numbers.
  void begin(int count) {
    size_ = count;
    for (int k = 0; k < kPackets; ++k) {
      first_[k] = k * kWidth;
      lanes_[k] = Mask::first(count - k * kWidth).bits();
    }
  }
  /// No path is in flight.
  void clear() {
    begin(0);
    kept_ = 0;
  }

  int size() const { return size_; }
  Mask lanes(int packet) const { return Mask::from_bits(lanes_[packet]); }

  /// Entries of a packet's lanes.
  Int entries(int packet) const {
    alignas(64) std::int32_t at[kWidth] = {};
    std::int32_t next = first_[packet];
    for (std::uint32_t bits = lanes_[packet]; bits != 0; bits &= bits - 1) at[__builtin_ctz(bits)] = next++;
    return Int::load(at);
  }
  WidePath path(const SceneTables& scene, Int entry, Mask lanes) const {
    WidePath path;
    PathState::for_each(
        scene, [&](auto& to, const auto& from) { to = gather_lanes_of(to, from, entry, lanes); }, path,
        static_cast<const PathFields<InMemory>&>(paths));
    return path;
  }
  Hit hit(Int entry, Mask lanes) const {
    Hit hit;
    HitState::for_each([&](auto& to, const auto& from) { to = gather(&from[0], entry, lanes); }, hit, hits);
    return hit;
  }

  /// Packets are replaced in their order, each with what goes on of it.
  void replace(const SceneTables& scene, int packet, const WidePath& next, Mask alive) {
    first_[packet] = kept_;
    lanes_[packet] = alive.bits();
    // Entries are read before they are overwritten, and never move up.
    kept_ += append(scene, next, alive, paths, kept_);
  }
  void drop(int packet) { lanes_[packet] = 0; }
  /// All packets have been replaced.
  void end_step() {
    size_ = kept_;
    kept_ = 0;
  }

 private:
  template <class T, class Memory>
  static TESSERA_INLINE T gather_lanes_of(const T&, const Memory& from, Int entry, Mask lanes) {
    return gather_lanes<T>(from, entry, lanes);
  }

  int size_ = 0, kept_ = 0;
  std::int32_t first_[kPackets];  // entry of a packet's first lane in flight
  std::uint32_t lanes_[kPackets];
};

/// Sets random numbers on the way of a join to this event of the subpath from the light apart from others.
inline constexpr std::uint32_t join_salt(int event) {
  return static_cast<std::uint32_t>(event + 1) * 0x9e3779b9u;
}

/// Sums of subpaths by slot, as they leave their vertices.
struct WeightState {
  alignas(64) Lanes<float> last, rest;

  PartialWeights load(int packet) const {
    return {Float::load(last + packet * kWidth), Float::load(rest + packet * kWidth)};
  }
  void store(const PartialWeights& weights, int packet) {
    weights.last.store(last + packet * kWidth);
    weights.rest.store(rest + packet * kWidth);
  }
};

}  // namespace tessera::render::TESSERA_ISA
