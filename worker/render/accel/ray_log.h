// Rays as they were traced, for measuring how fast they could be traced with no shading at all.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "render/accel/ray_query.h"

namespace tessera::render {

enum class RayKind { kCamera, kBounce, kShadow };
inline constexpr int kRayKinds = 3;

/// Their times are not kept: of what moves, it is traced where it is when the shutter opens.
struct RayLog {
  /// One call of the query.
  struct Call {
    bool occluded;  // else: nearest
    bool coherent;
    std::int32_t count;  // rays
    /// Index in `data` of arrays of `stride()` floats: origin x y z, direction x y z, distance (occluded).
    std::size_t first;
    RayKind kind() const {
      return occluded ? RayKind::kShadow : coherent ? RayKind::kCamera : RayKind::kBounce;
    }
    std::size_t stride() const { return (static_cast<std::size_t>(count) + 15) / 16 * 16; }
  };
  std::vector<Call> calls;
  std::vector<float> data;
};

/// Asks another query, and keeps what was asked. For one thread; both outlive it.
class RecordingQuery final : public RayQuery {
 public:
  RecordingQuery(const RayQuery& query, RayLog& log) : query_(query), log_(log) {}
  void nearest(const RayArrays& rays, int n, bool coherent, const HitArrays& hits) const override;
  void occluded(const RayArrays& rays, int n, float* distance_in_blocked_out) const override;

 private:
  const RayQuery& query_;
  RayLog& log_;
};

/// Asks all rays of a kind in the log again; returns how many there are, and how many hit something (so that
/// nothing is optimised away).
struct Replayed {
  std::uint64_t rays = 0, hits = 0;
};
Replayed replay(const RayQuery& query, const RayLog& log, RayKind kind);

}  // namespace tessera::render
