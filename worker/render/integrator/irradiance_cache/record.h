// Irradiance at a point, and how it changes around it: what the cache is made of.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "render/color/bands.h"
#include "render/core/vec.h"

namespace tessera::render::TESSERA_ISA {

/// Light that other surfaces bring to a point, through the hemisphere around `n` [Ward, Rubinstein & Clear
/// 1988]. Lamps that shine on the point themselves are not in it.
struct IrradianceRecord {
  float p[3];    // render space
  float n[3];    // unit
  float radius;  // about the distance of what is seen from there
  float pixel;   // width of a pixel of the film there
  float irradiance[kBands];
  // Its change with the normal, along the axis about which that turns, a radian; and with the place, a unit
  // of length [Ward & Heckbert 1992].
  float rotation[kBands][3];
  float translation[kBands][3];
};

/// The error of the irradiance at `p`, where the normal is `n`, if it is taken to be the record's, relative
/// to it: that of half a sphere of light and half of darkness, each `radius` away [Ward, Rubinstein & Clear
/// 1988, equation 5]. Infinite for points behind the record, which see what it does not.
TESSERA_INLINE Float split_sphere_error(const IrradianceRecord& record, Vec3 p, Vec3 n) {
  const Vec3 d{p.x - record.p[0], p.y - record.p[1], p.z - record.p[2]};
  const Vec3 own{Float(record.n[0]), Float(record.n[1]), Float(record.n[2])};
  // Points of a curved surface lie a little behind each other where its normals are interpolated.
  constexpr float kBehind = 0.02f;
  const Mask behind = dot(d, n + own) < -2 * kBehind * record.radius;
  const Float error = length(d) * (1 / record.radius) + safe_sqrt(1.0f - dot(n, own));
  return select(behind, Float(1e30f), error);
}

/// The distance from it up to which its error can be below `error`.
inline float reach_of(const IrradianceRecord& record, float error) { return record.radius * error; }

/// The bytes of a blob, and what is in it: nothing else gives the same.
std::string blob_of(std::span<const IrradianceRecord> records);
/// Appends the records of a blob. False, and nothing appended, where it is not one: damaged, of another
/// length, or with numbers that no record has.
bool append_records(std::string_view blob, std::vector<IrradianceRecord>& records);

}  // namespace tessera::render::TESSERA_ISA
