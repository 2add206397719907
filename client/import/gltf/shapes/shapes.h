// The meshes of a glTF scene, placed.
#pragma once

#include <vector>

#include "import/gltf/context.h"
#include "import/gltf/file/accessors.h"
#include "import/gltf/matter/materials.h"
#include "import/gltf/nodes.h"

namespace tessera::client::gltf {

/// The box about all that was placed, in the world; empty where nothing was.
struct Extent {
  Imath::V3d low{0, 0, 0}, high{0, 0, 0};
  bool is_empty = true;

  void add(const Imath::V3d& p);
};

/// Writes shapes, objects and instances. What a mesh is on several nodes becomes an object, unless it emits.
Extent write_shapes(Context& context, BufferTable& buffers, AccessorTable& accessors,
                    MaterialTable& materials, const std::vector<Node>& nodes);

}  // namespace tessera::client::gltf
