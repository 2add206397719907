#include "render/accel/replay.h"

#include <algorithm>

namespace tessera::render::TESSERA_ISA {

void record_rays(const RayArrays& rays, const float* distance, int n, RayLog::Kind kind, bool coherent, RayLog& log) {
  const RayLog::Call call{kind, coherent, n, log.data.size()};
  const std::size_t stride = call.stride();
  log.calls.push_back(call);
  log.data.resize(log.data.size() + (distance ? 7 : 6) * stride);
  float* to = log.data.data() + call.first;
  for (const float* from : {rays.ox, rays.oy, rays.oz, rays.dx, rays.dy, rays.dz}) {
    to = std::copy_n(from, stride, to);
  }
  if (distance) std::copy_n(distance, stride, to);
}

std::uint64_t replay_rays(RTCScene scene, const RayLog& log) {
  constexpr std::size_t kMost = 2048;
  alignas(64) static thread_local float arrays[7][kMost];
  alignas(64) static thread_local float t[kMost], u[kMost], v[kMost];
  alignas(64) static thread_local std::int32_t primitive[kMost], shape[kMost], instance[kMost];
  std::uint64_t met = 0;
  for (const RayLog::Call& call : log.calls) {
    const bool shadow = call.kind == RayLog::Kind::kShadow;
    const std::size_t stride = std::min(call.stride(), kMost);
    for (std::size_t a = 0; a < (shadow ? 7u : 6u); ++a) {
      std::copy_n(log.data.data() + call.first + a * call.stride(), stride, arrays[a]);
    }
    const RayArrays rays{arrays[0], arrays[1], arrays[2], arrays[3], arrays[4], arrays[5]};
    if (shadow) {
      trace_shadow(scene, rays, call.count, Traversal::kIncoherent, arrays[6]);
      for (int i = 0; i < call.count; ++i) met += arrays[6][i] < 0;
    } else {
      trace_nearest(scene, rays, call.count, call.coherent ? Traversal::kCoherent : Traversal::kIncoherent, 0,
                    {t, u, v, primitive, shape, instance});
      for (int i = 0; i < call.count; ++i) met += shape[i] >= 0;
    }
  }
  return met;
}

}  // namespace tessera::render::TESSERA_ISA
