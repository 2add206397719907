// Primitives of glTF meshes -> meshes of triangles, as they stand on one node.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "import/gltf/context.h"
#include "import/gltf/file/accessors.h"
#include "import/gltf/matter/materials.h"
#include "import/gltf/nodes.h"
#include "wire/mesh_blob.h"

namespace tessera::client::gltf {

/// Vertices of a primitive, in the space of its node, or of the world where a skin placed them.
struct Primitive {
  wire::MeshData mesh;
  std::vector<float> colors, alphas;  // values at vertices, empty where there are none

  Vertices vertices() const { return {!mesh.uvs.empty(), !colors.empty(), !alphas.empty()}; }
};

/// The bending of a mesh on a node: none where both are empty.
struct Deformation {
  std::vector<double> weights;                // weights of the morph targets
  std::vector<Imath::M44d> world_from_joint;  // inverse bind matrices included; empty: no skin

  bool operator==(const Deformation&) const = default;
};

class PrimitiveReader {
 public:
  PrimitiveReader(Context& context, BufferTable& buffers, AccessorTable& accessors)
      : context_(context), buffers_(buffers), accessors_(accessors) {}

  /// With texture coordinates of `texture_set`, v upwards. Nothing for points and lines, and where something
  /// is wrong, which has been reported.
  std::optional<Primitive> read(const Json& primitive, const std::string& place, int texture_set,
                                const Deformation& deformation);

 private:
  using Floats = std::optional<std::vector<float>>;

  /// An attribute, whose format the rules have checked. Nothing where there is none.
  Floats attribute(const std::string& name);
  bool read_vertices(int texture_set, Primitive& result);
  bool read_indices(Primitive& result);
  void read_colors(Primitive& result);
  bool morph(const std::vector<double>& weights, wire::MeshData& mesh);
  bool bend(const std::vector<Imath::M44d>& world_from_joint, wire::MeshData& mesh);
  bool decode_draco(const Json& draco, const std::string& place);

  Context& context_;
  BufferTable& buffers_;
  AccessorTable& accessors_;
  // The primitive that is read.
  const Json* json_ = nullptr;
  std::string place_;
  std::size_t vertex_count_ = 0;
  struct Decoded {
    std::string name;
    std::vector<float> values;
  };
  std::vector<Decoded> decoded_;  // attributes out of compressed data
  std::vector<std::uint32_t> decoded_indices_;
  bool is_compressed_ = false;
};

/// Decodes KHR_draco_mesh_compression; `attributes` are names, the data's own ids, and components
/// (draco.cpp). A message for what is damaged.
struct DracoAttribute {
  std::string name;
  std::uint32_t id;
  int components;
  std::vector<float> values;
};
std::string decode_draco_mesh(std::string_view bytes, std::size_t most_vertices,
                              std::vector<DracoAttribute>& attributes, std::vector<std::uint32_t>& indices);

}  // namespace tessera::client::gltf
