// A shape of any kind but combinations, by what builds its kind.
#include "render/scene/shape/geometry.h"
#include "render/scene/shape/shape_kinds.h"

namespace tessera::render {

const ShapeKindRow* find_shape_kind(const v1::Shape& shape) {
  for (const auto& family : {mesh_kinds(), quadric_kinds(), round_solid_kinds(), flat_kinds(),
                             sdf_grid_kinds(), implicit_kinds(), curve_kinds(), combination_kinds()}) {
    for (const ShapeKindRow& row : family) {
      if (row.message == shape.kind_case()) return &row;
    }
  }
  return nullptr;
}

const char* kind_without_light(const v1::Shape& shape) {
  const ShapeKindRow* const row = find_shape_kind(shape);
  return row == nullptr || row->without_light == nullptr ? nullptr : row->without_light(shape);
}

absl::Status add_geometry(const v1::Shape& shape, const Transform& placed_from_object, bool as_triangles,
                          const BlobSource& blobs, ShapeTable& table, ShapeRecord& record,
                          const std::stop_token& stop, std::span<const Transform> later_places) {
  const ShapeKindRow* const row = find_shape_kind(shape);
  if (row == nullptr || row->add == nullptr)
    return absl::InvalidArgumentError("its kind is missing or unknown");
  return row->add({.shape = shape,
                   .placed_from_object = placed_from_object,
                   .blobs = blobs,
                   .table = table,
                   .record = record,
                   .as_triangles = as_triangles,
                   .later_places = later_places,
                   .stop = stop});
}

}  // namespace tessera::render
