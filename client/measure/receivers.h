// Receivers of meters, as the places of probes.
#pragma once

#include <ImathVec.h>

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "import/input/imported_scene.h"
#include "measure/cell_triangle.h"
#include "measure/measured.h"
#include "tessera/v1/meter.pb.h"
#include "tessera/v1/probe.pb.h"

namespace tessera::client {

/// A place where something is received, with all but the kind of a probe.
struct ReceiverPlace {
  v1::Probe probe;
  double area = 0;                    // of a cell, world units squared; points have none
  std::vector<Imath::V3d> positions;  // of the cells
  Imath::V3d normal{};                // unit length; 0 where it differs
  std::optional<MeasuredPlane> plane;
  std::vector<SceneBlob> blobs;  // meshes of the probe that the scene does not have
  // Where each cell is a triangle of a surface: theirs, and the mesh. The probe is of none of them yet.
  std::vector<CellTriangle> triangles;
  std::optional<MeasuredMesh> mesh;
};

/// Part of a receiver's width: far enough from a surface that rounding does not put it behind.
inline constexpr double kReceiverOffset = 1e-4;

/// InvalidArgument with what is wrong. `up`: of points that have no normal.
absl::StatusOr<ReceiverPlace> place_of(const v1::Receiver& receiver, const ImportedScene& scene,
                                       const Imath::V3d& up);

/// The place on the other side of the same surface.
ReceiverPlace other_side(ReceiverPlace place);

/// All shapes of the scene that have this name.
std::vector<const v1::Shape*> shapes_named(const ImportedScene& scene, const std::string& name);

Imath::V3d vector_of(const v1::Point3& p);
v1::Point3 point_of(const Imath::V3d& v);

}  // namespace tessera::client
