// In which shapes a point is, by two tests that know nothing of each other.
#pragma once

#include <mutex>

#include "render/query/query_scene.h"
#include "render/query/winding.h"

namespace tessera::render {

struct QueryScene::MeshFacts {
  std::once_flag once;
  std::unique_ptr<const WindingTree> winding;
  bool closed = true;
};

}  // namespace tessera::render
