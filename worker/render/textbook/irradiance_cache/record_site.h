// How far from the place of a record its light holds.
#pragma once

#include "render/color/bands.h"
#include "render/core/vec.h"
#include "wire/phases/glossy_records.h"

namespace tessera::render::TESSERA_ISA {

using wire::GlossyRecords;
using wire::IrradianceRecord;
using wire::RecordSite;
static_assert(wire::kRecordBands == kBands);

/// The error of the light at `p`, where the normal is `n`, if it is taken to be that of the record at `site`,
/// relative to it: that of half a sphere of light and half of darkness, each `radius` away [Ward, Rubinstein
/// & Clear 1988, equation 5]. Infinite for points behind the record, which see what it does not.
TESSERA_INLINE Float split_sphere_error(const RecordSite& site, Vec3 p, Vec3 n) {
  const Vec3 d{p.x - site.p[0], p.y - site.p[1], p.z - site.p[2]};
  const Vec3 own{Float(site.n[0]), Float(site.n[1]), Float(site.n[2])};
  // Points of a curved surface lie a little behind each other where its normals are interpolated.
  constexpr float kBehind = 0.02f;
  const Mask behind = dot(d, n + own) < -2 * kBehind * site.radius;
  const Float error = length(d) * (1 / site.radius) + safe_sqrt(1.0f - dot(n, own));
  return select(behind, Float(1e30f), error);
}

/// The distance from it up to which its error can be below `error`.
inline float reach_of(const RecordSite& site, float error) { return site.radius * error; }

}  // namespace tessera::render::TESSERA_ISA
