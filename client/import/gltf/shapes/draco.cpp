// Google's Draco: the codec of KHR_draco_mesh_compression.
#include <draco/compression/decode.h>

#include <cmath>
#include <new>

#include "import/gltf/shapes/primitives.h"

namespace tessera::client::gltf {

std::string decode_draco_mesh(std::string_view bytes, std::size_t most_vertices,
                              std::vector<DracoAttribute>& attributes,
                              std::vector<std::uint32_t>& indices) try {
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  draco::Decoder decoder;
  auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok()) return concat("the Draco data are damaged: ", decoded.status().error_msg_string());
  const draco::Mesh& mesh = *decoded.value();
  if (mesh.num_points() > most_vertices)
    return concat("the Draco data have ", mesh.num_points(), " vertices, the accessors ", most_vertices);
  for (DracoAttribute& attribute : attributes) {
    const draco::PointAttribute* source = mesh.GetAttributeByUniqueId(attribute.id);
    if (source == nullptr) return concat("the Draco data have no attribute ", attribute.id);
    const auto components = static_cast<std::size_t>(attribute.components);
    attribute.values.resize(mesh.num_points() * components);
    for (std::uint32_t i = 0; i < mesh.num_points(); ++i) {
      float* to = attribute.values.data() + i * components;
      if (!source->ConvertValue<float>(source->mapped_index(draco::PointIndex(i)),
                                       static_cast<std::int8_t>(attribute.components), to))
        return concat("the values of the Draco attribute ", attribute.id, " are not numbers");
      for (std::size_t c = 0; c < components; ++c) {
        if (!std::isfinite(to[c]))
          return concat("a value of the Draco attribute ", attribute.id, " is not finite");
      }
    }
  }
  for (std::uint32_t f = 0; f < mesh.num_faces(); ++f) {
    for (const draco::PointIndex& corner : mesh.face(draco::FaceIndex(f))) {
      if (corner.value() >= mesh.num_points())
        return "a triangle of the Draco data has a vertex that is not there";
      indices.push_back(corner.value());
    }
  }
  return "";
} catch (const std::bad_alloc&) {
  return "the Draco data ask for more memory than there is";
}

}  // namespace tessera::client::gltf
