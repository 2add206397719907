#include "render/build/texture/mesh_attributes.h"

#include <cmath>
#include <cstring>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "render/build/values/located.h"

namespace tessera::render {

absl::Status MeshAttributes::add(const v1::TriangleMesh& mesh, const ShapeTable& shapes, std::int32_t shape) {
  const ShapeRecord& record = shapes.shapes[static_cast<std::size_t>(shape)];
  for (const v1::MeshAttribute& source : mesh.attributes()) {
    const auto name = names_.find(source.name());
    if (name == names_.end()) continue;  // nothing looks at it
    const auto bytes = blobs_(source.blob().digest());
    const std::string where = absl::StrCat("attribute '", source.name(), "'");
    if (!bytes.ok()) return located(bytes.status(), where);
    const std::size_t channels = source.channels();
    const std::size_t entries =
        static_cast<std::size_t>(source.per_face() ? record.triangle_count : record.vertex_count);
    if ((channels != 1 && channels != 3) || bytes->bytes.size() != entries * channels * sizeof(float)) {
      return absl::InvalidArgumentError(absl::StrCat(where, ": ", bytes->bytes.size(), " bytes are not ",
                                                     entries, " values of ", channels, " channels (1 or 3)"));
    }
    std::vector<float> values(entries * channels);
    if (!values.empty()) std::memcpy(values.data(), bytes->bytes.data(), bytes->bytes.size());
    for (const float x : values) {
      if (!std::isfinite(x))
        return absl::InvalidArgumentError(absl::StrCat(where, ": a value is not finite"));
    }
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
    table_.attribute_of_shape[table_.attribute_slot(shape, name->second)] =
        static_cast<std::int32_t>(table_.attributes.size());
    table_.attributes.push_back(std::move(attribute));
  }
  return absl::OkStatus();
}

}  // namespace tessera::render
