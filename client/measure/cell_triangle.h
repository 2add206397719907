// Triangles of surfaces that are cells of meters.
#pragma once

#include <ImathVec.h>

#include "import/input/imported_scene.h"
#include "tessera/v1/probe.pb.h"

namespace tessera::client {

/// World space. Light is received on the side of edge_u x edge_v, or the other one of a probe that is inward.
struct CellTriangle {
  Imath::V3d corner{}, edge_u{}, edge_v{};
  double offset = 0;  // of the probe

  double area() const { return (edge_u % edge_v).length() / 2; }
};

/// The mesh that probes of triangles share: (0, 0, 0), (1, 0, 0), (0, 1, 0).
const SceneBlob& unit_triangle();

/// Puts a probe on the triangle, which has an area.
void place_on(const CellTriangle& triangle, v1::Probe& probe);

}  // namespace tessera::client
