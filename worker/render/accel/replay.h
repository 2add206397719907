// Recording and replaying rays.
#pragma once

#include "render/accel/ray_log.h"
#include "render/accel/trace.h"

namespace tessera::render::TESSERA_ISA {

/// `distance` is null for rays that look for the nearest hit.
void record_rays(const RayArrays& rays, const float* distance, int n, RayLog::Kind kind, bool coherent, RayLog& log);

/// Traces all rays of the log just as they were traced; returns how many hit something (so that nothing is optimised away).
std::uint64_t replay_rays(RTCScene scene, const RayLog& log);

}  // namespace tessera::render::TESSERA_ISA
