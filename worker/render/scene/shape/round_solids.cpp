// Half-spaces, cones, cylinders with caps, tori and ellipsoids: each of size 1 in an object space of its own.
#include <algorithm>
#include <cmath>

#include "render/scene/shape/geometry.h"

namespace tessera::render {

namespace {

/// Scales, then moves up the z axis.
Transform scaled_and_raised(double x, double y, double z, double up) {
  Transform t;
  t.m = {x, 0, 0, 0, 0, y, 0, 0, 0, 0, z, up};
  return t;
}

bool is_length(double x) { return x > 0 && std::isfinite(x); }

absl::Status add_half_space(const v1::Shape& shape, const Transform& placed_from_object, ShapeTable& table,
                            ShapeRecord& record, Transform* exact) {
  if (!std::isfinite(shape.half_space().height())) {
    return absl::InvalidArgumentError("its height is not finite");
  }
  constexpr double kReach = 1e9;
  record.kind = ShapeKind::kHalfSpace;
  QuadricRecord q;
  q.radius =
      static_cast<float>(std::min(kReach, kFarthestPlane / largest_scale(placed_from_object.to_affine())));
  return place_quadric(shape,
                       placed_from_object * Transform::translation({0, 0, shape.half_space().height()}), q,
                       table, record, exact);
}

struct FrustumSize {
  double bottom = 0, top = 0;  // radii
  double z_min = 0, z_max = 0;
  bool capped = false;
  double phi_max_degrees = 360;
};

absl::Status add_frustum(const v1::Shape& shape, const FrustumSize& size, const Transform& placed_from_object,
                         ShapeTable& table, ShapeRecord& record, Transform* exact) {
  const double widest = std::max(size.bottom, size.top), half = (size.z_max - size.z_min) / 2;
  if (!is_length(widest) || !(size.bottom >= 0) || !(size.top >= 0) || !is_length(half) ||
      !(size.phi_max_degrees > 0)) {
    return absl::InvalidArgumentError("its radius, height or angle is not usable");
  }
  record.kind = ShapeKind::kFrustum;
  QuadricRecord q;
  q.radius = static_cast<float>(size.bottom / widest);
  q.top_radius = static_cast<float>(size.top / widest);
  q.capped = size.capped;
  q.partial = size.phi_max_degrees < 360;
  q.phi_max = static_cast<float>(std::clamp(size.phi_max_degrees, 1e-3, 360.0)) * 0.01745329251994f;
  const Transform object_from_unit = scaled_and_raised(widest, widest, half, (size.z_min + size.z_max) / 2);
  return place_quadric(shape, placed_from_object * object_from_unit, q, table, record, exact);
}

absl::Status add_cone(const v1::Shape& shape, const Transform& placed_from_object, ShapeTable& table,
                      ShapeRecord& record, Transform* exact) {
  const v1::Cone& cone = shape.cone();
  return add_frustum(shape,
                     {.bottom = cone.radius(),
                      .top = cone.top_radius(),
                      .z_min = 0,
                      .z_max = cone.height(),
                      .capped = cone.capped(),
                      .phi_max_degrees = cone.has_phi_max_degrees() ? cone.phi_max_degrees() : 360},
                     placed_from_object, table, record, exact);
}

absl::Status add_capped_cylinder(const v1::Shape& shape, const Transform& placed_from_object,
                                 ShapeTable& table, ShapeRecord& record, Transform* exact) {
  const v1::Cylinder& cylinder = shape.cylinder();
  return add_frustum(shape,
                     {.bottom = cylinder.radius(),
                      .top = cylinder.radius(),
                      .z_min = std::min(cylinder.z_min(), cylinder.z_max()),
                      .z_max = std::max(cylinder.z_min(), cylinder.z_max()),
                      .capped = true,
                      .phi_max_degrees = cylinder.has_phi_max_degrees() ? cylinder.phi_max_degrees() : 360},
                     placed_from_object, table, record, exact);
}

absl::Status add_torus(const v1::Shape& shape, const Transform& placed_from_object, ShapeTable& table,
                       ShapeRecord& record, Transform* exact) {
  const double circle = shape.torus().major_radius(), tube = shape.torus().minor_radius();
  constexpr double kThinnest = 1e-5;
  if (!is_length(circle) || !(tube < circle) || !(tube > kThinnest * circle)) {
    return absl::InvalidArgumentError("a torus wants 1e-5 major_radius < minor_radius < major_radius");
  }
  record.kind = ShapeKind::kTorus;
  QuadricRecord q;
  q.inner_radius = static_cast<float>(tube / circle);
  return place_quadric(shape, placed_from_object * scaled_and_raised(circle, circle, circle, 0), q, table,
                       record, exact);
}

/// A sphere of radius 1 in a space of its own.
absl::Status add_ellipsoid(const v1::Shape& shape, const Transform& placed_from_object, ShapeTable& table,
                           ShapeRecord& record, Transform* exact) {
  const auto& radii = shape.ellipsoid().radii();
  if (radii.size() != 3 || !std::all_of(radii.begin(), radii.end(), is_length)) {
    return absl::InvalidArgumentError("an ellipsoid wants three radii above 0");
  }
  record.kind = ShapeKind::kSphere;
  return place_quadric(shape, placed_from_object * scaled_and_raised(radii[0], radii[1], radii[2], 0),
                       QuadricRecord{}, table, record, exact);
}

}  // namespace

absl::Status add_round_solid(const v1::Shape& shape, const Transform& placed_from_object, ShapeTable& table,
                             ShapeRecord& record, Transform* exact) {
  switch (shape.kind_case()) {
    case v1::Shape::kHalfSpace:
      return add_half_space(shape, placed_from_object, table, record, exact);
    case v1::Shape::kCone:
      return add_cone(shape, placed_from_object, table, record, exact);
    case v1::Shape::kTorus:
      return add_torus(shape, placed_from_object, table, record, exact);
    case v1::Shape::kEllipsoid:
      return add_ellipsoid(shape, placed_from_object, table, record, exact);
    default:
      return add_capped_cylinder(shape, placed_from_object, table, record, exact);
  }
}

}  // namespace tessera::render
