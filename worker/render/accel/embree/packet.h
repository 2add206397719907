// Embree's packets are as wide as one native vector: 16 rays on AVX-512, 8 on AVX2, 4 on NEON.
#pragma once

#include "render/accel/embree/embree.h"
#include "render/core/wide.h"

namespace tessera::render::TESSERA_ISA {

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
inline constexpr int kPacket = kPartWidth;
static_assert(sizeof(RayPacket::org_x) == kPacket * sizeof(float));

}  // namespace tessera::render::TESSERA_ISA
