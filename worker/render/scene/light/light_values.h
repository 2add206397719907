// Points, directions and colours of messages into the arrays of a LightRecord.
#pragma once

#include "render/scene/placement/transform.h"
#include "render/scene/values/spectra.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::render {

inline void put(const spectra::Rgb& rgb, float scale, float (&to)[3]) {
  to[0] = rgb.r * scale, to[1] = rgb.g * scale, to[2] = rgb.b * scale;
}

inline Imath::V3d point_of(const v1::Point3& p) { return {p.x(), p.y(), p.z()}; }

}  // namespace tessera::render
