// A scene of nothing, for jobs.
#pragma once

#include <cstdint>

#include "import/input/imported_scene.h"

namespace tessera::client {

inline ImportedScene scene_of(std::uint32_t width, std::uint32_t height) {
  ImportedScene imported;
  imported.scene.mutable_film()->set_width(width);
  imported.scene.mutable_film()->set_height(height);
  return imported;
}

}  // namespace tessera::client
