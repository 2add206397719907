// What a pixel covers of a surface, however the path came there.
#pragma once

#include "render/core/texture_point.h"
#include "render/sensor/footprint_record.h"

namespace tessera::render::TESSERA_ISA {

/// Sets the footprint of `at`: the circle of the record's part of a pixel about a ray from the camera
/// straight to at.p, projected along the ray to the plane of `n` [pbrt-v4, Camera::Approximate_dp_dxy]. It
/// depends on nothing but the point, so that all ways that lead there agree on the texture, paths from lights
/// too; in a flat mirror, where the way is longer than that, it is smaller than what the pixel covers. `n` is
/// the geometric normal; `dpdu` and `dpdv` the derivatives of the point.
void set_footprint(const FootprintRecord& sensor, Vec3 n, Vec3 dpdu, Vec3 dpdv, TexturePoint& at);

}  // namespace tessera::render::TESSERA_ISA
