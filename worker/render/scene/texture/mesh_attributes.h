// Values over meshes that textures look up.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "render/color/texture_table.h"
#include "render/scene/blob_source.h"
#include "render/shape/shape_table.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::render {

class MeshAttributes {
 public:
  /// `names`: those that textures look up, with their numbers (TextureBuilder::attribute_names()). Fills the
  /// attributes of `table`.
  MeshAttributes(const std::map<std::string, int>& names, const BlobSource& blobs, TextureTable& table)
      : names_(names), blobs_(blobs), table_(table) {}

  /// Adds those of `mesh` that are looked up; `shape` is what it has become. Shapes come in order.
  /// InvalidArgument names the attribute.
  absl::Status add(const v1::TriangleMesh& mesh, const ShapeTable& shapes, std::int32_t shape);
  /// Errors of add().
  absl::Status check(const v1::TriangleMesh& mesh) const;

 private:
  bool is_looked_up(const v1::MeshAttribute& source) const { return names_.contains(source.name()); }
  absl::StatusOr<std::vector<float>> read(const v1::MeshAttribute& source, std::size_t vertices,
                                          std::size_t triangles) const;

  const std::map<std::string, int>& names_;
  const BlobSource& blobs_;
  TextureTable& table_;
};

}  // namespace tessera::render
