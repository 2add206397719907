// pbrt shapes -> Shape messages.
#pragma once

#include <string>

#include "import/pbrt/matter/textures.h"
#include "wire/mesh_blob.h"

namespace tessera::client::pbrt {

/// Parts that a shape still needs when its message is written.
struct ShapeResult {
  bool kept = false;          // false: left out, with a warning, or after an error
  std::string ply_file;       // file of a plymesh, as the scene names it
  std::string alpha_texture;  // it may be defined further on in the file
  /// Set for a mesh that emits: pbrt-v4 makes a light of each triangle or patch.
  std::size_t triangles_per_light = 1;
};

/// Fills in the geometry of a shape of `type` (any but "curve"), and its alpha where that is constant.
ShapeResult write_shape(const std::string& type, ValueReader& values, v1::Shape& shape);

/// Reads "alpha" and warns of parameters that nothing has asked for: the end of every shape.
void finish_shape(ValueReader& values, v1::Shape& shape, ShapeResult& result);

struct SurfaceArea {
  double total = 0;           // area in world space
  std::size_t triangles = 1;  // triangles of a mesh
  bool triangles_of_equal_area = true;
};

/// Meshes are looked up in the blobs. Exact for boxes and polygons, and for spheres, disks and cylinders
/// under uniform scaling; zero where it is not known.
SurfaceArea world_area(const v1::Shape& shape, const Imath::M44d& world_from_object,
                       const BlobCollector& blobs);

/// Geometric normals of triangles that have vertex normals are on their side in pbrt-v4, whatever the
/// winding: turns the triangles that disagree.
void turn_faces_to_normals(wire::MeshData& mesh);

}  // namespace tessera::client::pbrt
