#include "render/scene/texture/mesh_attributes.h"

#include <cmath>
#include <cstring>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "render/scene/values/located.h"
#include "wire/mesh_blob.h"

namespace tessera::render {

absl::StatusOr<std::vector<float>> MeshAttributes::read(const v1::MeshAttribute& source, std::size_t vertices,
                                                        std::size_t triangles) const {
  const auto bytes = blobs_(source.blob().digest());
  const std::string where = absl::StrCat("attribute '", source.name(), "'");
  if (!bytes.ok()) return located(bytes.status(), where);
  const std::size_t channels = source.channels(), entries = source.per_face() ? triangles : vertices;
  if ((channels != 1 && channels != 3) || bytes->bytes.size() != entries * channels * sizeof(float)) {
    return absl::InvalidArgumentError(absl::StrCat(where, ": ", bytes->bytes.size(), " bytes are not ",
                                                   entries, " values of ", channels, " channels (1 or 3)"));
  }
  std::vector<float> values(entries * channels);
  if (!values.empty()) std::memcpy(values.data(), bytes->bytes.data(), bytes->bytes.size());
  for (const float x : values) {
    if (!std::isfinite(x)) return absl::InvalidArgumentError(absl::StrCat(where, ": a value is not finite"));
  }
  return values;
}

absl::Status MeshAttributes::check(const v1::TriangleMesh& mesh) const {
  for (const v1::MeshAttribute& source : mesh.attributes()) {
    if (!is_looked_up(source)) continue;
    const auto bytes = blobs_(mesh.blob().digest());
    if (!bytes.ok()) return bytes.status();
    const auto view = wire::decode_mesh(bytes->bytes);
    if (!view.ok()) return view.status();
    if (auto values = read(source, view->vertex_count(), view->triangle_count()); !values.ok())
      return values.status();
  }
  return absl::OkStatus();
}

absl::Status MeshAttributes::add(const v1::TriangleMesh& mesh, const ShapeTable& shapes, std::int32_t shape) {
  const ShapeRecord& record = shapes.shapes[static_cast<std::size_t>(shape)];
  for (const v1::MeshAttribute& source : mesh.attributes()) {
    if (!is_looked_up(source)) continue;
    auto read_values = read(source, static_cast<std::size_t>(record.vertex_count),
                            static_cast<std::size_t>(record.triangle_count));
    if (!read_values.ok()) return read_values.status();
    std::vector<float> values = *std::move(read_values);
    const std::size_t channels = source.channels();
    MeshAttribute attribute;
    attribute.channels = static_cast<std::int32_t>(channels);
    attribute.per_face = source.per_face();
    if (attribute.per_face) {
      attribute.values = std::move(values);
    } else {
      // A corner of every triangle, as the winding of the triangle now is.
      const std::uint32_t* index =
          shapes.triangles.data() + 3 * static_cast<std::size_t>(record.first_triangle);
      attribute.values.reserve(3 * channels * static_cast<std::size_t>(record.triangle_count));
      for (std::int32_t i = 0; i < 3 * record.triangle_count; ++i) {
        const float* value = values.data() + index[i] * channels;
        attribute.values.insert(attribute.values.end(), value, value + channels);
      }
    }
    // Shapes come in order, so the lookup only grows.
    table_.attribute_of_shape.resize(table_.attribute_slot(shape + 1, 0), -1);
    table_.attribute_of_shape[table_.attribute_slot(shape, names_.at(source.name()))] =
        static_cast<std::int32_t>(table_.attributes.size());
    table_.attributes.push_back(std::move(attribute));
  }
  return absl::OkStatus();
}

}  // namespace tessera::render
