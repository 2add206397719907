#include "render/accel/ray_log.h"

#include <algorithm>

namespace tessera::render {

namespace {

/// `distance` is null for rays that look for the nearest hit.
void record(const RayArrays& rays, const float* distance, int n, bool coherent, RayLog& log) {
  const RayLog::Call call{distance != nullptr, coherent, n, log.data.size()};
  const std::size_t stride = call.stride();
  log.calls.push_back(call);
  log.data.resize(log.data.size() + (distance ? 7 : 6) * stride);
  float* to = log.data.data() + call.first;
  for (const float* from : {rays.ox, rays.oy, rays.oz, rays.dx, rays.dy, rays.dz}) {
    to = std::copy_n(from, stride, to);
  }
  if (distance) std::copy_n(distance, stride, to);
}

}  // namespace

void RecordingQuery::nearest(const RayArrays& rays, int n, bool coherent, const HitArrays& hits) const {
  record(rays, nullptr, n, coherent, log_);
  query_.nearest(rays, n, coherent, hits);
}

void RecordingQuery::occluded(const RayArrays& rays, int n, float* distance_in_blocked_out) const {
  record(rays, distance_in_blocked_out, n, false, log_);
  query_.occluded(rays, n, distance_in_blocked_out);
}

Replayed replay(const RayQuery& query, const RayLog& log, RayKind kind) {
  constexpr std::size_t kMost = 2048;
  alignas(64) static thread_local float arrays[7][kMost];
  alignas(64) static thread_local float t[kMost], u[kMost], v[kMost];
  alignas(64) static thread_local std::int32_t primitive[kMost], shape[kMost], instance[kMost];
  Replayed replayed;
  for (const RayLog::Call& call : log.calls) {
    if (call.kind() != kind) continue;
    replayed.rays += static_cast<std::uint64_t>(call.count);
    const std::size_t stride = std::min(call.stride(), kMost);
    for (std::size_t a = 0; a < (call.occluded ? 7u : 6u); ++a) {
      std::copy_n(log.data.data() + call.first + a * call.stride(), stride, arrays[a]);
    }
    const RayArrays rays{arrays[0], arrays[1], arrays[2], arrays[3], arrays[4], arrays[5]};
    if (call.occluded) {
      query.occluded(rays, call.count, arrays[6]);
      for (int i = 0; i < call.count; ++i) replayed.hits += arrays[6][i] < 0;
    } else {
      query.nearest(rays, call.count, call.coherent, {t, u, v, primitive, shape, instance});
      for (int i = 0; i < call.count; ++i) replayed.hits += shape[i] >= 0;
    }
  }
  return replayed;
}

}  // namespace tessera::render
