// Spheres, disks, cylinders, and grids of signed distances.
#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "render/build/scene_builder.h"
#include "wire/volume_blob.h"

namespace tessera::render {

absl::Status SceneBuilder::add_quadric(const v1::Shape& shape, const Transform& placed_from_object,
                                       ShapeRecord& record) {
  Transform object_from_placed;
  if (!placed_from_object.invert(object_from_placed)) {
    return absl::InvalidArgumentError("its transform is singular");
  }
  if (!fits_floats(placed_from_object, object_from_placed)) return absl::InvalidArgumentError(kBeyondFloats);
  QuadricRecord q;
  q.render_from_object = placed_from_object.to_affine();
  q.object_from_render = object_from_placed.to_affine();
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
  if (shape.uv_transform_size() != 0 && shape.uv_transform_size() != 6) {
    return absl::InvalidArgumentError("a uv transform has six numbers");
  }
  q.maps_uv = shape.uv_transform_size() == 6;
  for (int i = 0; i < shape.uv_transform_size(); ++i) {
    q.uv_map[i] = shape.uv_transform(i);
    if (!std::isfinite(q.uv_map[i])) return absl::InvalidArgumentError("its uv transform is not finite");
  }
  if (shape.reverse_orientation() != (placed_from_object.determinant() < 0)) record.flags |= kFlipNormal;
  record.quadric = static_cast<std::int32_t>(arrays_.shapes.quadrics.size());
  arrays_.shapes.quadrics.push_back(q);
  return absl::OkStatus();
}

absl::Status SceneBuilder::add_sdf_grid(const v1::Shape& shape, const Transform& placed_from_object,
                                        ShapeRecord& record) {
  const auto bytes = blobs_(shape.sdf_grid().blob().digest());
  if (!bytes.ok()) return located(bytes.status(), absl::StrCat("volume ", shape.sdf_grid().blob().digest()));
  const auto volume = wire::decode_volume(bytes->bytes);
  if (!volume.ok()) return volume.status();
  if (volume->channels != 1 || std::min({volume->nx, volume->ny, volume->nz}) < 2 ||
      volume->samples.size() > (std::size_t{1} << 30)) {
    return absl::InvalidArgumentError(
        "a grid of distances has one channel and 2 to 2^30 samples, at least two along each axis");
  }
  Transform object_from_placed;
  if (!placed_from_object.invert(object_from_placed))
    return absl::InvalidArgumentError("its transform is singular");
  if (!fits_floats(placed_from_object, object_from_placed)) return absl::InvalidArgumentError(kBeyondFloats);
  SdfGridRecord grid;
  grid.render_from_object = placed_from_object.to_affine();
  grid.object_from_render = object_from_placed.to_affine();
  grid.smooth_normals = shape.sdf_grid().smooth_normals();
  const std::uint32_t sizes[] = {volume->nx, volume->ny, volume->nz};
  for (int i = 0; i < 3; ++i) grid.size[i] = static_cast<std::int32_t>(sizes[i]);
  grid.samples.assign(volume->samples.begin(), volume->samples.end());

  // Voxels whose corners do not all lie on one side.
  const std::int32_t row = grid.size[0], slice = row * grid.size[1];
  for (std::int32_t z = 0; z + 1 < grid.size[2]; ++z) {
    for (std::int32_t y = 0; y + 1 < grid.size[1]; ++y) {
      for (std::int32_t x = 0; x + 1 < grid.size[0]; ++x) {
        const std::int32_t lower = z * slice + y * row + x;
        int inside = 0, outside = 0;
        for (int i = 0; i < 8; ++i) {
          const float f =
              grid.samples[static_cast<std::size_t>(lower + (i & 1) + (i >> 1 & 1) * row + (i >> 2) * slice)];
          inside += f <= 0, outside += f >= 0;
        }
        if (inside > 0 && outside > 0) grid.voxels.push_back(lower);
      }
    }
  }
  record.kind = ShapeKind::kSdfGrid;
  if (shape.reverse_orientation() != (placed_from_object.determinant() < 0)) record.flags |= kFlipNormal;
  record.quadric = static_cast<std::int32_t>(arrays_.shapes.sdf_grids.size());
  arrays_.shapes.sdf_grids.push_back(std::move(grid));
  return absl::OkStatus();
}

}  // namespace tessera::render
