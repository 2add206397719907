#include "measure/cell_triangle.h"

#include "import/input/blob_collector.h"
#include "wire/mesh_blob.h"

namespace tessera::client {

const SceneBlob& unit_triangle() {
  static const SceneBlob triangle = [] {
    wire::MeshData mesh;
    mesh.positions = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    mesh.indices = {0, 1, 2};
    BlobCollector blobs;
    blobs.add_bytes(wire::encode_mesh(mesh));
    return blobs.take().front();
  }();
  return triangle;
}

void place_on(const CellTriangle& triangle, v1::Probe& probe) {
  *probe.mutable_mesh()->mutable_mesh() = unit_triangle().ref;
  // A third axis along the normal keeps the side that the mesh's normals are on.
  const Imath::V3d normal = (triangle.edge_u % triangle.edge_v).normalized();
  auto& elements = *probe.mutable_mesh()->mutable_world_from_mesh()->mutable_elements();
  elements.Clear();
  for (int row = 0; row < 3; ++row) {
    for (const Imath::V3d& column : {triangle.edge_u, triangle.edge_v, normal, triangle.corner})
      elements.Add(column[row]);
  }
  for (const double element : {0.0, 0.0, 0.0, 1.0}) elements.Add(element);
  probe.set_offset(triangle.offset);
}

}  // namespace tessera::client
