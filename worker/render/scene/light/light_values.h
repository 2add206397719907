// Points, directions and colours of messages into the arrays of a LightRecord.
#pragma once

#include "render/scene/placement/transform.h"
#include "render/scene/values/spectra.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::render {

inline void put(const spectra::Rgb& rgb, float scale, float (&to)[3]) {
  to[0] = rgb.r * scale, to[1] = rgb.g * scale, to[2] = rgb.b * scale;
}

/// Luminance in cd/m^2 of a radiance of 1.
inline double luminance_of_radiance(const v1::SceneUnits& units) {
  return units.cd_per_m2() > 0 ? units.cd_per_m2() : 683;
}

inline Imath::V3d point_of(const v1::Point3& p) { return {p.x(), p.y(), p.z()}; }

}  // namespace tessera::render
