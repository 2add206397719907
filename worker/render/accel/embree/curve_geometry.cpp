#include "render/accel/embree/curve_geometry.h"

#include "render/shape/curve_table.h"

namespace tessera::render {

RTCGeometry new_curve_geometry(RTCDevice device, const CurvesRecord& curves) {
  const bool ribbon = curves.kind == CurveKind::kRibbon;
  // Cylinders are flat too: pbrt-v4's differ from its flat curves in nothing but their normals, and a fibre's
  // BSDF stands for all that happens inside of it.
  const RTCGeometryType type =
      curves.bspline
          ? (ribbon ? RTC_GEOMETRY_TYPE_NORMAL_ORIENTED_BSPLINE_CURVE : RTC_GEOMETRY_TYPE_FLAT_BSPLINE_CURVE)
          : (ribbon ? RTC_GEOMETRY_TYPE_NORMAL_ORIENTED_BEZIER_CURVE : RTC_GEOMETRY_TYPE_FLAT_BEZIER_CURVE);
  RTCGeometry geometry = rtcNewGeometry(device, type);
  const auto keys = static_cast<unsigned>(curves.key_segments) + 1;
  const std::size_t count = curves.points.size() / keys;
  if (keys > 1) rtcSetGeometryTimeStepCount(geometry, keys);
  for (unsigned key = 0; key < keys; ++key) {
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, key, RTC_FORMAT_FLOAT4, curves.points.data(),
                               key * count * sizeof(CurvePoint), sizeof(CurvePoint), count);
    // The normals keep their directions.
    if (ribbon) {
      rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_NORMAL, key, RTC_FORMAT_FLOAT3,
                                 curves.normals.data(), 0, 3 * sizeof(float), count);
    }
  }
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, curves.starts.data(), 0,
                             sizeof(curves.starts[0]), curves.starts.size());
  rtcSetGeometryTessellationRate(geometry, static_cast<float>(curves.pieces));
  return geometry;
}

}  // namespace tessera::render
