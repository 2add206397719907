// Grids of signed distances.
#include <algorithm>

#include "absl/strings/str_cat.h"
#include "render/scene/shape/geometry.h"
#include "render/scene/shape/shape_kinds.h"
#include "render/scene/values/located.h"
#include "wire/volume_blob.h"

namespace tessera::render {

namespace {

/// Finds the voxels whose corners do not all lie on one side.
void find_voxels(SdfGridRecord& grid) {
  const std::int32_t row = grid.size[0], slice = row * grid.size[1];
  for (std::int32_t z = 0; z + 1 < grid.size[2]; ++z) {
    for (std::int32_t y = 0; y + 1 < grid.size[1]; ++y) {
      for (std::int32_t x = 0; x + 1 < grid.size[0]; ++x) {
        const std::int32_t lower = z * slice + y * row + x;
        int inside = 0, outside = 0;
        for (int i = 0; i < 8; ++i) {
          const std::int32_t corner = lower + (i & 1) + (i >> 1 & 1) * row + (i >> 2) * slice;
          const float f = grid.samples[static_cast<std::size_t>(corner)];
          inside += f <= 0, outside += f >= 0;
        }
        if (inside > 0 && outside > 0) grid.voxels.push_back(lower);
      }
    }
  }
}

absl::Status add_sdf_grid(const ShapeToAdd& wanted) {
  const v1::Shape& shape = wanted.shape;
  const auto bytes = wanted.blobs(shape.sdf_grid().blob().digest());
  if (!bytes.ok()) return located(bytes.status(), absl::StrCat("volume ", shape.sdf_grid().blob().digest()));
  const auto volume = wire::decode_volume(bytes->bytes);
  if (!volume.ok()) return volume.status();
  if (volume->channels != 1 || std::min({volume->nx, volume->ny, volume->nz}) < 2 ||
      volume->samples.size() > (std::size_t{1} << 30)) {
    return absl::InvalidArgumentError(
        "a grid of distances has one channel and 2 to 2^30 samples, at least two along each axis");
  }
  Transform object_from_placed;
  if (!wanted.placed_from_object.invert(object_from_placed))
    return absl::InvalidArgumentError("its transform is singular");
  if (!fits_floats(wanted.placed_from_object, object_from_placed))
    return absl::InvalidArgumentError(kBeyondFloats);
  SdfGridRecord grid;
  grid.render_from_object = wanted.placed_from_object.to_affine();
  grid.object_from_render = object_from_placed.to_affine();
  grid.smooth_normals = shape.sdf_grid().smooth_normals();
  const std::uint32_t sizes[] = {volume->nx, volume->ny, volume->nz};
  for (int i = 0; i < 3; ++i) grid.size[i] = static_cast<std::int32_t>(sizes[i]);
  grid.samples.assign(volume->samples.begin(), volume->samples.end());

  find_voxels(grid);
  wanted.record.kind = ShapeKind::kSdfGrid;
  if (shape.reverse_orientation() != (wanted.placed_from_object.determinant() < 0))
    wanted.record.flags |= kFlipNormal;
  wanted.record.quadric = static_cast<std::int32_t>(wanted.table.sdf_grids.size());
  wanted.table.sdf_grids.push_back(std::move(grid));
  return absl::OkStatus();
}

constexpr ShapeKindRow kSdfGrid{
    .message = v1::Shape::kSdfGrid,
    .add = &add_sdf_grid,
    .without_light = [](const v1::Shape&) { return "a grid of distances"; },
    .why_open = [](const v1::Shape&) { return "a grid of distances may be open, and cannot be combined"; }};

}  // namespace

std::span<const ShapeKindRow> sdf_grid_kinds() { return {&kSdfGrid, 1}; }

}  // namespace tessera::render
