// Errors that name the place in the scene.
#pragma once

#include <string>

#include "absl/status/status.h"
#include "wire/scene_place.h"

namespace tessera::render {

using wire::place_in_scene;

/// "shape 12 (lamp): " before the message of a status that is not OK.
absl::Status located(const absl::Status& status, const std::string& where);

}  // namespace tessera::render
