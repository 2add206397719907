// Spheres, disks and cylinders.
#include <algorithm>
#include <cmath>

#include "render/scene/shape/geometry.h"
#include "render/scene/shape/shape_kinds.h"

namespace tessera::render {

absl::Status compose_uv_map(const v1::Shape& shape, QuadricRecord& q) {
  if (shape.uv_transform_size() == 0) return absl::OkStatus();
  if (shape.uv_transform_size() != 6) return absl::InvalidArgumentError("a uv transform has six numbers");
  const auto& wanted = shape.uv_transform();
  float own[6];
  std::copy(q.uv_map, q.uv_map + 6, own);
  for (int i = 0; i < 6; ++i) {
    const int row = i / 3 * 3, column = i % 3;
    q.uv_map[i] =
        wanted[row] * own[column] + wanted[row + 1] * own[3 + column] + (column == 2 ? wanted[row + 2] : 0);
    if (!std::isfinite(q.uv_map[i])) return absl::InvalidArgumentError("its uv transform is not finite");
  }
  q.maps_uv = 1;
  return absl::OkStatus();
}

absl::Status place_quadric(const ShapeToAdd& wanted, const Transform& placed_from_object, QuadricRecord q) {
  Transform object_from_placed;
  if (!placed_from_object.invert(object_from_placed)) {
    return absl::InvalidArgumentError("its transform is singular");
  }
  if (!fits_floats(placed_from_object, object_from_placed)) return absl::InvalidArgumentError(kBeyondFloats);
  q.render_from_object = placed_from_object.to_affine();
  q.object_from_render = object_from_placed.to_affine();
  if (auto s = compose_uv_map(wanted.shape, q); !s.ok()) return s;
  if (wanted.shape.reverse_orientation()) wanted.record.flags ^= kFlipNormal;
  wanted.record.quadric = static_cast<std::int32_t>(wanted.table.quadrics.size());
  wanted.table.quadrics.push_back(q);
  if (wanted.exact != nullptr) *wanted.exact = placed_from_object;
  return absl::OkStatus();
}

namespace {

absl::Status add_quadric(const ShapeToAdd& wanted) {
  const v1::Shape& shape = wanted.shape;
  ShapeRecord& record = wanted.record;
  QuadricRecord q;
  float phi_max = 360;
  if (shape.has_sphere()) {
    const v1::Sphere& sphere = shape.sphere();
    record.kind = ShapeKind::kSphere;
    q.radius = sphere.radius();
    q.z_min = std::clamp(sphere.has_z_min() ? sphere.z_min() : -q.radius, -q.radius, q.radius);
    q.z_max = std::clamp(sphere.has_z_max() ? sphere.z_max() : q.radius, -q.radius, q.radius);
    if (q.z_min > q.z_max) std::swap(q.z_min, q.z_max);
    if (sphere.has_phi_max_degrees()) phi_max = sphere.phi_max_degrees();
    q.partial = q.z_min > -q.radius || q.z_max < q.radius || phi_max < 360;
  } else if (shape.has_cylinder()) {
    const v1::Cylinder& cylinder = shape.cylinder();
    record.kind = ShapeKind::kCylinder;
    q.radius = cylinder.radius();
    q.z_min = std::min(cylinder.z_min(), cylinder.z_max());
    q.z_max = std::max(cylinder.z_min(), cylinder.z_max());
    if (!(q.z_min < q.z_max) || !std::isfinite(q.z_max - q.z_min)) {
      return absl::InvalidArgumentError("a cylinder without height");
    }
    if (cylinder.has_phi_max_degrees()) phi_max = cylinder.phi_max_degrees();
    q.partial = phi_max < 360;
  } else {
    const v1::Disk& disk = shape.disk();
    record.kind = ShapeKind::kDisk;
    q.radius = disk.radius();
    q.inner_radius = disk.inner_radius();
    q.height = disk.height();
    if (disk.has_phi_max_degrees()) phi_max = disk.phi_max_degrees();
    q.partial = phi_max < 360;
  }
  q.phi_max = std::clamp(phi_max, 1e-3f, 360.0f) * 0.01745329251994f;
  if (!(q.radius > 0) || !std::isfinite(q.radius) || !std::isfinite(q.height) || !(q.inner_radius >= 0) ||
      (record.kind == ShapeKind::kDisk && q.inner_radius >= q.radius) || !(phi_max > 0)) {
    return absl::InvalidArgumentError("its radius, height or angle is not usable");
  }
  if (wanted.placed_from_object.determinant() < 0) record.flags ^= kFlipNormal;  // the same as in pbrt
  return place_quadric(wanted, wanted.placed_from_object, q);
}

const char* why_open_sphere(const v1::Shape& shape) {
  const v1::Sphere& sphere = shape.sphere();
  return sphere.has_z_min() || sphere.has_z_max() || is_cut(sphere) ? "a part of a sphere is not closed"
                                                                    : nullptr;
}

CsgBox box_of_sphere(const QuadricRecord& q, const Transform& placed) {
  const double r = q.radius;
  return box_about(placed, {r, r, r});
}

constexpr ShapeKindRow kQuadrics[] = {
    {.message = v1::Shape::kSphere, .add = &add_quadric, .why_open = &why_open_sphere, .box = &box_of_sphere},
    {.message = v1::Shape::kDisk,
     .add = &add_quadric,
     .why_open = [](const v1::Shape&) { return "a disk is not closed"; }},
    {.message = v1::Shape::kCylinder,
     .add =
         [](const ShapeToAdd& wanted) {
           return wanted.shape.cylinder().capped() ? add_capped_cylinder(wanted) : add_quadric(wanted);
         },
     .without_light =
         [](const v1::Shape& shape) { return shape.cylinder().capped() ? "a cylinder with caps" : nullptr; },
     .why_open =
         [](const v1::Shape& shape) {
           return !shape.cylinder().capped() ? "a cylinder without caps is not closed"
                  : is_cut(shape.cylinder()) ? "a cylinder that is cut by an angle is not closed"
                                             : nullptr;
         },
     .box = &box_of_unit_cube}};

}  // namespace

std::span<const ShapeKindRow> quadric_kinds() { return kQuadrics; }

}  // namespace tessera::render
