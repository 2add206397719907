// Participating media by name, for shapes and the camera.
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "render/scene/values/name_table.h"

namespace tessera::render {

struct MediumNames {
  NameTable names{"medium", -1};
  bool left_out = false;  // the algorithm sees no media: every name is that of none

  /// The medium's index, -1: none. InvalidArgument where there is none of this name.
  absl::StatusOr<int> find(const std::string& name) const {
    return left_out ? absl::StatusOr<int>(-1) : names.find(name);
  }
};

}  // namespace tessera::render
