// Finds all faults of the shapes of a scene at once, without building it: for clients, before they
// submit.
#pragma once

#include <string>
#include <vector>

#include "render/build/blob_source.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::render {

/// A shape, or an operand of a combination, that cannot be built.
struct ShapeFault {
  const v1::Shape* shape;  // in the scene's message
  std::string place;       // "shape 12 (lamp)", as errors of load_scene() begin
  std::string message;
};

/// Faults of all shapes in their order, `most` of them at most; by the builders of geometry.h, whose errors
/// of load_scene() these are. Only the places of meshes and curves are looked at, and meshes that are
/// operands.
std::vector<ShapeFault> find_shape_faults(const v1::Scene& scene, const BlobSource& blobs, std::size_t most);

}  // namespace tessera::render
