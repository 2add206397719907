#include "render/accel/trace.h"

#include <algorithm>

namespace tessera::render::TESSERA_ISA {

namespace {

// Embree's packets are as wide as one native vector: 16 rays on AVX-512, 8 on AVX2, 4 on NEON.
#if defined(__AVX512F__)
using Packet = RTCRayHit16;
using RayPacket = RTCRay16;
#elif defined(__AVX2__)
using Packet = RTCRayHit8;
using RayPacket = RTCRay8;
#else
using Packet = RTCRayHit4;
using RayPacket = RTCRay4;
#endif
constexpr int kPacket = kPartWidth;
static_assert(sizeof(RayPacket::org_x) == kPacket * sizeof(float));

using FloatTag = Tag<float>;
using UIntTag = Tag<std::uint32_t>;

/// -1 for the first `n` lanes of a packet.
void set_valid(int n, int* valid) {
  for (int i = 0; i < kPacket; ++i) valid[i] = i < n ? -1 : 0;
}

void copy(const float* from, float* to) { hn::Store(hn::Load(FloatTag(), from), FloatTag(), to); }
void fill(float value, float* to) { hn::Store(hn::Set(FloatTag(), value), FloatTag(), to); }
void fill(std::uint32_t value, unsigned* to) {
  hn::Store(hn::Set(UIntTag(), value), UIntTag(), reinterpret_cast<std::uint32_t*>(to));
}

void load_rays(const RayArrays& rays, int first, RayPacket& packet) {
  copy(rays.ox + first, packet.org_x);
  copy(rays.oy + first, packet.org_y);
  copy(rays.oz + first, packet.org_z);
  copy(rays.dx + first, packet.dir_x);
  copy(rays.dy + first, packet.dir_y);
  copy(rays.dz + first, packet.dir_z);
  fill(0.0f, packet.tnear);
  if (rays.time) {
    copy(rays.time + first, packet.time);
  } else {
    fill(0.0f, packet.time);
  }
  fill(0xffffffffu, packet.mask);
  fill(0u, packet.id);
  fill(0u, packet.flags);
}

}  // namespace

void trace_nearest(RTCScene scene, const RayArrays& rays, int n, bool coherent, std::int32_t first_instance,
                   const HitArrays& hits) {
  TraceContext context(coherent);
  Packet packet;
  alignas(64) int valid[kPacket];
  for (int first = 0; first < n; first += kPacket) {
    set_valid(n - first, valid);
    load_rays(rays, first, packet.ray);
    fill(__builtin_inff(), packet.ray.tfar);
    fill(RTC_INVALID_GEOMETRY_ID, packet.hit.geomID);
    fill(RTC_INVALID_GEOMETRY_ID, packet.hit.instID[0]);
    context.intersect(valid, scene, packet);

    copy(packet.ray.tfar, hits.t + first);
    copy(packet.hit.u, hits.u + first);
    copy(packet.hit.v, hits.v + first);
    std::copy_n(packet.hit.primID, kPacket, hits.primitive + first);
    std::copy_n(packet.hit.geomID, kPacket, hits.shape + first);
    for (int i = 0; i < kPacket; ++i) {
      const auto id = static_cast<std::int32_t>(packet.hit.instID[0][i]);
      hits.instance[first + i] = id < 0 ? -1 : id - first_instance;
    }
  }
}

void trace_shadow(RTCScene scene, const RayArrays& rays, int n, float* distance_in_blocked_out) {
  if (n == 0) return;
  TraceContext context(false);
#if TESSERA_EMBREE == 3
  // Streams read whole arrays; constants are shared by all batches.
  constexpr int kChunk = 1024;
  alignas(64) static thread_local float zero[kChunk];
  alignas(64) static thread_local unsigned all[kChunk], none[kChunk];
  if (all[0] == 0) std::fill_n(all, kChunk, ~0u);
  for (int first = 0; first < n; first += kChunk) {
    const int count = std::min(kChunk, n - first);
    RTCRayNp stream{};
    stream.org_x = const_cast<float*>(rays.ox) + first;
    stream.org_y = const_cast<float*>(rays.oy) + first;
    stream.org_z = const_cast<float*>(rays.oz) + first;
    stream.dir_x = const_cast<float*>(rays.dx) + first;
    stream.dir_y = const_cast<float*>(rays.dy) + first;
    stream.dir_z = const_cast<float*>(rays.dz) + first;
    stream.tnear = zero;
    stream.time = rays.time ? const_cast<float*>(rays.time) + first : zero;
    stream.tfar = distance_in_blocked_out + first;
    stream.mask = all;
    stream.id = none;
    stream.flags = none;
    context.occluded_stream(scene, stream, static_cast<unsigned>(count));
  }
#else
  RayPacket packet;
  alignas(64) int valid[kPacket];
  for (int first = 0; first < n; first += kPacket) {
    set_valid(n - first, valid);
    load_rays(rays, first, packet);
    copy(distance_in_blocked_out + first, packet.tfar);
    context.occluded(valid, scene, packet);
    copy(packet.tfar, distance_in_blocked_out + first);
  }
#endif
}

}  // namespace tessera::render::TESSERA_ISA
