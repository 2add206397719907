// Probes as kernels read them: what every pixel of the raster reads, and where (ProbeCamera).
#pragma once

#include <cstdint>
#include <vector>

namespace tessera::render {

/// How radiance is weighed: Probe.Kind, in its order.
enum class ProbeKind : std::int32_t {
  kCone,
  kPlane,
  kSphere,
  kCylinder,
  kHalfCylinder,
  kHalfSphere,
  kExitance,
  kFarField
};

/// Where a probe reads.
enum class ProbePlace : std::int32_t { kPoint, kPlane, kMesh, kDisk, kSphere };

/// Lengths and places are of render space, directions unit vectors.
struct ProbeRecord {
  ProbeKind kind = ProbeKind::kPlane;
  ProbePlace place = ProbePlace::kPoint;
  float origin[3] = {};                  // the point, a plane's corner, or the middle
  float edge_u[3] = {}, edge_v[3] = {};  // of one cell of a plane
  float axis[3] = {0, 0, 1};             // not of meshes and spheres, whose axis is the normal there
  float front[3] = {1, 0, 0};            // at right angles to the axis
  float radius = 0;                      // of disks and spheres
  float one_minus_cos = 0;               // of half of a cone's field
  float side = 1;                        // -1: the side against the normals of meshes and spheres
  float offset = 0;                      // along the axis, where rays begin
  bool at_middles = false;               // of cells
  std::int32_t first_triangle = 0, last_triangle = 0;  // of a mesh
};

/// Samples of a pixel lie no farther from its middle than this: no rounding takes one to a neighbour, which
/// may read something else.
inline constexpr float kProbeFilterRadius = 0.49f;

struct ProbeTable {
  std::vector<ProbeRecord> probes;
  // By pixel, row by row. Probes of pixels that read nothing are -1.
  std::vector<std::int32_t> probe_of_pixel;
  std::vector<float> column_of_pixel, row_of_pixel;  // its cell, of planes
  std::int32_t pixels = 0;                           // that read something: the first ones
  // Nine numbers each: a corner, and the two edges from there. Areas add up to 1 over a mesh.
  std::vector<float> triangles, area_before_triangle;
};

/// Whether paths from lights can be joined to what the probe reads.
inline bool connects(const ProbeRecord& probe) {
  return probe.kind != ProbeKind::kExitance && (probe.kind != ProbeKind::kCone || probe.one_minus_cos > 0);
}
/// Whether light that is sampled at the place of the probe is part of its reading. A cone shows the radiance
/// of what is there, to which lights without a surface add nothing.
inline bool samples_lights(const ProbeRecord& probe) {
  return probe.kind != ProbeKind::kExitance && probe.kind != ProbeKind::kCone;
}

}  // namespace tessera::render
