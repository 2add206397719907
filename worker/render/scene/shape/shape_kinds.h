// The kinds of shapes that messages may be of, each in the file that reads it.
#pragma once

#include <span>
#include <stop_token>

#include "absl/status/status.h"
#include "render/scene/blob_source.h"
#include "render/scene/placement/transform.h"
#include "render/scene/shape/csg_solid.h"
#include "render/shape/shape_table.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::render {

/// A shape to be appended to a table, and the record that will say where it is there.
struct ShapeToAdd {
  const v1::Shape& shape;
  const Transform& placed_from_object;
  const BlobSource& blobs;
  ShapeTable& table;
  ShapeRecord& record;
  bool as_triangles = false;                     // flat shapes as the triangles that they consist of
  std::span<const Transform> later_places = {};  // of a mesh, at later keys
  std::stop_token stop = {};                     // meshes throw Stopped once it is requested
  Transform* exact = nullptr;  // if wanted: where its object space was placed, in double precision
};

struct ShapeKindRow {
  v1::Shape::KindCase message;
  /// Appends the geometry. InvalidArgument for sizes and placements that are not usable.
  absl::Status (*add)(const ShapeToAdd& wanted) = nullptr;
  /// Names the shape where an area light is an error ("a torus"); null, as its result, where it may emit
  /// light.
  const char* (*without_light)(const v1::Shape& shape) = nullptr;
  /// Tells why the shape bounds no solid; null, as its result, for solids.
  const char* (*why_open)(const v1::Shape& shape) = nullptr;
  /// The box about a solid whose own space is placed so; null for those that have another one beside them.
  CsgBox (*box)(const QuadricRecord& solid, const Transform& placed) = nullptr;
};

// One function a file that reads messages of shapes.
std::span<const ShapeKindRow> mesh_kinds();
std::span<const ShapeKindRow> quadric_kinds();      // spheres, disks, cylinders
std::span<const ShapeKindRow> round_solid_kinds();  // half-spaces, cones, tori, ellipsoids
std::span<const ShapeKindRow> flat_kinds();         // polygons, boxes, convex polyhedra
std::span<const ShapeKindRow> sdf_grid_kinds();
std::span<const ShapeKindRow> implicit_kinds();
std::span<const ShapeKindRow> curve_kinds();
std::span<const ShapeKindRow> combination_kinds();

// quadrics.cpp
/// Appends `q` where a shape is whose own space is placed so, with its parameters mapped and its normal
/// turned as the shape says. InvalidArgument where the transform is singular or beyond floats.
absl::Status place_quadric(const ShapeToAdd& wanted, const Transform& placed_from_object, QuadricRecord q);
// round_solids.cpp
absl::Status add_capped_cylinder(const ShapeToAdd& wanted);
// csg_solid.cpp
/// ShapeKindRow::box of solids that fill the cube from -1 to 1 of their space.
CsgBox box_of_unit_cube(const QuadricRecord& solid, const Transform& placed);

/// Whether less than a full turn of a round shape's message is there.
template <class Message>
bool is_cut(const Message& round) {
  return round.has_phi_max_degrees() && round.phi_max_degrees() < 360;
}

/// Null where the message is of no kind, or of one that is not known.
const ShapeKindRow* find_shape_kind(const v1::Shape& shape);

}  // namespace tessera::render
