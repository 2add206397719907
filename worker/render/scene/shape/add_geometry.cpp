// A shape of any kind but combinations, by what builds its kind.
#include "render/scene/shape/geometry.h"

namespace tessera::render {

const char* kind_without_light(const v1::Shape& shape) {
  switch (shape.kind_case()) {
    case v1::Shape::kSdfGrid:
      return "a grid of distances";
    case v1::Shape::kHalfSpace:
      return "a half-space";
    case v1::Shape::kCone:
      return "a cone";
    case v1::Shape::kTorus:
      return "a torus";
    case v1::Shape::kImplicit:
      return "an implicit surface";
    case v1::Shape::kCsg:
      return "a combination of solids";
    case v1::Shape::kCylinder:
      return shape.cylinder().capped() ? "a cylinder with caps" : nullptr;
    default:
      return nullptr;
  }
}

absl::Status add_geometry(const v1::Shape& shape, const Transform& placed_from_object, bool as_triangles,
                          const BlobSource& blobs, ShapeTable& table, ShapeRecord& record,
                          const std::stop_token& stop) {
  switch (shape.kind_case()) {
    case v1::Shape::kMesh:
      return add_mesh(shape, placed_from_object, blobs, table, record, stop);
    case v1::Shape::kSphere:
    case v1::Shape::kDisk:
      return add_quadric(shape, placed_from_object, table, record);
    case v1::Shape::kCylinder:
      return shape.cylinder().capped() ? add_round_solid(shape, placed_from_object, table, record)
                                       : add_quadric(shape, placed_from_object, table, record);
    case v1::Shape::kHalfSpace:
    case v1::Shape::kCone:
    case v1::Shape::kTorus:
    case v1::Shape::kEllipsoid:
      return add_round_solid(shape, placed_from_object, table, record);
    case v1::Shape::kPolygon:
    case v1::Shape::kBox:
    case v1::Shape::kPolyhedron:
      return add_flat_shape(shape, placed_from_object, as_triangles, table, record);
    case v1::Shape::kSdfGrid:
      return add_sdf_grid(shape, placed_from_object, blobs, table, record);
    case v1::Shape::kImplicit:
      return add_implicit(shape, placed_from_object, table, record);
    case v1::Shape::kCurves:
      return add_curves(shape, placed_from_object, blobs, table, record);
    case v1::Shape::kCsg:  // add_csg()
    case v1::Shape::KIND_NOT_SET:
      break;
  }
  return absl::InvalidArgumentError("its kind is missing or unknown");
}

}  // namespace tessera::render
