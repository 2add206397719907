// Receivers of meters, as the places of probes.
#pragma once

#include <ImathVec.h>

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "import/input/imported_scene.h"
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
};

/// InvalidArgument with what is wrong. `up`: of points that have no normal.
absl::StatusOr<ReceiverPlace> place_of(const v1::Receiver& receiver, const ImportedScene& scene,
                                       const Imath::V3d& up);

/// The place on the other side of the same surface.
ReceiverPlace other_side(ReceiverPlace place);

/// The surface of a shape of the scene. InvalidArgument names the nearest name where there is no such shape,
/// and shapes whose surfaces cannot be read.
absl::StatusOr<ReceiverPlace> surface_of(const v1::Shape& shape, const ImportedScene& scene, bool inside);

/// All shapes of the scene that have this name.
std::vector<const v1::Shape*> shapes_named(const ImportedScene& scene, const std::string& name);

Imath::V3d vector_of(const v1::Point3& p);
v1::Point3 point_of(const Imath::V3d& v);

}  // namespace tessera::client
