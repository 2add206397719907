// One shape of a scene's messages -> its record and arrays in the ShapeTable.
#pragma once

#include <map>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "render/bsdf/material_table.h"
#include "render/scene/blob_source.h"
#include "render/scene/medium/medium_names.h"
#include "render/scene/placement/transform.h"
#include "render/scene/shape/emitter.h"
#include "render/scene/texture/mesh_attributes.h"
#include "render/scene/texture/texture_nodes.h"
#include "render/scene/values/name_table.h"
#include "render/shape/shape_table.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::render {

/// Names and blobs that shapes refer to.
struct ShapeInputs {
  const BlobSource& blobs;  // source of meshes, curves and grids
  const NameTable& materials;
  const MaterialTable& material_table;
  const MediumNames& media;
  TextureNodes& textures;  // used for alpha
  MeshAttributes& attributes;
  bool triangles_only = false;  // flat shapes become meshes
  std::stop_token stop = {};    // stops building
};

class ShapeBuilder {
 public:
  ShapeBuilder(const ShapeInputs& inputs, ShapeTable& table, std::vector<std::string>& warnings)
      : inputs_(inputs), table_(table), warnings_(warnings) {}

  /// Adds a shape, unless there would be nothing of it to be seen. Those of objects (`instanced`) that emit
  /// light wait for their places. A mesh may stand elsewhere at later keys (add_geometry()). Warnings name
  /// `where`; InvalidArgument does not.
  absl::Status add(const v1::Shape& shape, const Transform& placed_from_object, bool instanced,
                   const std::string& where, std::span<const Transform> later_places = {});

  /// Whether a shape of an object emits light: each of its places in the world is a shape and lights of its
  /// own.
  bool waits_for_places(std::int32_t shape) const { return waiting_.contains(shape); }
  /// The shape for one more of the places of such a shape.
  absl::StatusOr<std::int32_t> place_emitter(std::int32_t shape);

  /// Appends the solids of all combinations behind all shapes: once all of these are there.
  absl::Status add_solids_of_combinations();

  /// The places in the scene of all shapes in the table, for messages.
  const std::vector<std::string>& names() const { return names_; }
  /// The messages of all shapes in the table.
  const std::vector<const v1::Shape*>& messages() const { return messages_; }
  /// Shapes that emit light, in order.
  const std::vector<Emitter>& emitters() const { return emitters_; }

 private:
  /// A shape of kind kCsg, and its solids, which wait for their places.
  struct Combination {
    std::int32_t shape = 0;
    std::vector<ShapeRecord> solids;
    std::vector<std::string> names;
    std::vector<const v1::Shape*> meshes;  // null: no mesh
  };

  /// A shape of an object that emits light.
  struct Waiting {
    Emitter emitter;
    bool placed = false;
  };

  absl::Status add_combination(const v1::Shape& shape, const Transform& placed_from_object,
                               const std::string& where, ShapeRecord& record);
  std::int32_t append(const v1::Shape& shape, const std::string& where, const ShapeRecord& record);
  absl::Status add_attributes(const v1::Shape& shape, std::int32_t index);
  absl::Status set_alpha(const v1::Shape& shape, ShapeRecord& record);
  absl::Status set_media(const v1::Shape& shape, ShapeRecord& record) const;
  absl::Status add_emitter(const v1::Shape& shape, bool instanced, const std::string& where,
                           std::int32_t index);

  const ShapeInputs inputs_;
  ShapeTable& table_;
  std::vector<std::string>& warnings_;
  std::vector<std::string> names_;
  std::vector<const v1::Shape*> messages_;
  std::vector<Emitter> emitters_;
  std::map<std::int32_t, Waiting> waiting_;  // by shape
  std::vector<Combination> combinations_;
};

}  // namespace tessera::render
