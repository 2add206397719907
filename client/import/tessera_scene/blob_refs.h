// All references to blobs in a Scene, wherever they stand.
#pragma once

#include <functional>

#include "google/protobuf/text_format.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::client::tessera_scene {

/// Where a message stands in its text form; null where that is not known.
using Locations = google::protobuf::TextFormat::ParseInfoTree;

/// Calls `visit` for every BlobRef of the scene. `is_mesh` tells those of triangle meshes; `line` counts from
/// 1, 0 is unknown.
void for_each_blob_ref(v1::Scene& scene, Locations* locations,
                       const std::function<void(v1::BlobRef& ref, bool is_mesh, int line)>& visit);

}  // namespace tessera::client::tessera_scene
