// Half-spaces, cones, cylinders with caps, tori and ellipsoids: each of size 1 in an object space of its own.
#include <algorithm>
#include <cmath>

#include "render/scene/shape/geometry.h"
#include "render/scene/shape/shape_kinds.h"

namespace tessera::render {

namespace {

/// Scales, then moves up the z axis.
Transform scaled_and_raised(double x, double y, double z, double up) {
  Transform t;
  t.m = {x, 0, 0, 0, 0, y, 0, 0, 0, 0, z, up};
  return t;
}

bool is_length(double x) { return x > 0 && std::isfinite(x); }

absl::Status add_half_space(const ShapeToAdd& wanted) {
  const double height = wanted.shape.half_space().height();
  if (!std::isfinite(height)) return absl::InvalidArgumentError("its height is not finite");
  constexpr double kReach = 1e9;
  wanted.record.kind = ShapeKind::kHalfSpace;
  QuadricRecord q;
  q.radius = static_cast<float>(
      std::min(kReach, kFarthestPlane / largest_scale(wanted.placed_from_object.to_affine())));
  return place_quadric(wanted, wanted.placed_from_object * Transform::translation({0, 0, height}), q);
}

/// Ends where the plane does, if that is straight across an axis.
CsgBox box_of_half_space(const QuadricRecord&, const Transform& t) {
  CsgBox box;
  const Imath::V3d at = t.apply({0, 0, 0}),
                   across = t.apply_vector({1, 0, 0}).cross(t.apply_vector({0, 1, 0})),
                   down = t.apply_vector({0, 0, -1});
  for (int a = 0; a < 3; ++a) {
    if (across[(a + 1) % 3] != 0 || across[(a + 2) % 3] != 0) continue;
    if (down[a] < 0) box.high[a] = at[a];
    if (down[a] > 0) box.low[a] = at[a];
  }
  return box;
}

struct FrustumSize {
  double bottom = 0, top = 0;  // radii
  double z_min = 0, z_max = 0;
  bool capped = false;
  double phi_max_degrees = 360;
};

absl::Status add_frustum(const ShapeToAdd& wanted, const FrustumSize& size) {
  const double widest = std::max(size.bottom, size.top), half = (size.z_max - size.z_min) / 2;
  if (!is_length(widest) || !(size.bottom >= 0) || !(size.top >= 0) || !is_length(half) ||
      !(size.phi_max_degrees > 0)) {
    return absl::InvalidArgumentError("its radius, height or angle is not usable");
  }
  wanted.record.kind = ShapeKind::kFrustum;
  QuadricRecord q;
  q.radius = static_cast<float>(size.bottom / widest);
  q.top_radius = static_cast<float>(size.top / widest);
  q.capped = size.capped;
  q.partial = size.phi_max_degrees < 360;
  q.phi_max = static_cast<float>(std::clamp(size.phi_max_degrees, 1e-3, 360.0)) * 0.01745329251994f;
  const Transform object_from_unit = scaled_and_raised(widest, widest, half, (size.z_min + size.z_max) / 2);
  return place_quadric(wanted, wanted.placed_from_object * object_from_unit, q);
}

absl::Status add_cone(const ShapeToAdd& wanted) {
  const v1::Cone& cone = wanted.shape.cone();
  return add_frustum(wanted, {.bottom = cone.radius(),
                              .top = cone.top_radius(),
                              .z_min = 0,
                              .z_max = cone.height(),
                              .capped = cone.capped(),
                              .phi_max_degrees = cone.has_phi_max_degrees() ? cone.phi_max_degrees() : 360});
}

const char* why_open_cone(const v1::Shape& shape) {
  return !shape.cone().capped() ? "a cone without caps is not closed"
         : is_cut(shape.cone()) ? "a cone that is cut by an angle is not closed"
                                : nullptr;
}

absl::Status add_torus(const ShapeToAdd& wanted) {
  const double circle = wanted.shape.torus().major_radius(), tube = wanted.shape.torus().minor_radius();
  constexpr double kThinnest = 1e-5;
  if (!is_length(circle) || !(tube < circle) || !(tube > kThinnest * circle)) {
    return absl::InvalidArgumentError("a torus wants 1e-5 major_radius < minor_radius < major_radius");
  }
  wanted.record.kind = ShapeKind::kTorus;
  QuadricRecord q;
  q.inner_radius = static_cast<float>(tube / circle);
  return place_quadric(wanted, wanted.placed_from_object * scaled_and_raised(circle, circle, circle, 0), q);
}

CsgBox box_of_torus(const QuadricRecord& q, const Transform& placed) {
  const double tube = q.inner_radius;
  return box_about(placed, {1 + tube, 1 + tube, tube});
}

/// A sphere of radius 1 in a space of its own.
absl::Status add_ellipsoid(const ShapeToAdd& wanted) {
  const auto& radii = wanted.shape.ellipsoid().radii();
  if (radii.size() != 3 || !std::all_of(radii.begin(), radii.end(), is_length)) {
    return absl::InvalidArgumentError("an ellipsoid wants three radii above 0");
  }
  wanted.record.kind = ShapeKind::kSphere;
  return place_quadric(wanted, wanted.placed_from_object * scaled_and_raised(radii[0], radii[1], radii[2], 0),
                       QuadricRecord{});
}

constexpr ShapeKindRow kRoundSolids[] = {
    {.message = v1::Shape::kHalfSpace,
     .add = &add_half_space,
     .without_light = [](const v1::Shape&) { return "a half-space"; },
     .box = &box_of_half_space},
    {.message = v1::Shape::kCone,
     .add = &add_cone,
     .without_light = [](const v1::Shape&) { return "a cone"; },
     .why_open = &why_open_cone,
     .box = &box_of_unit_cube},
    {.message = v1::Shape::kTorus,
     .add = &add_torus,
     .without_light = [](const v1::Shape&) { return "a torus"; },
     .box = &box_of_torus},
    {.message = v1::Shape::kEllipsoid, .add = &add_ellipsoid, .box = &box_of_unit_cube}};

}  // namespace

absl::Status add_capped_cylinder(const ShapeToAdd& wanted) {
  const v1::Cylinder& cylinder = wanted.shape.cylinder();
  return add_frustum(wanted,
                     {.bottom = cylinder.radius(),
                      .top = cylinder.radius(),
                      .z_min = std::min(cylinder.z_min(), cylinder.z_max()),
                      .z_max = std::max(cylinder.z_min(), cylinder.z_max()),
                      .capped = true,
                      .phi_max_degrees = cylinder.has_phi_max_degrees() ? cylinder.phi_max_degrees() : 360});
}

std::span<const ShapeKindRow> round_solid_kinds() { return kRoundSolids; }

}  // namespace tessera::render
