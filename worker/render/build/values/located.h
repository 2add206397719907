// Errors that name the place in the scene.
#pragma once

#include <string>

#include "absl/status/status.h"

namespace tessera::render {

/// "shape 12 (lamp)"
std::string place_in_scene(const char* what, int index, const std::string& name);

/// "shape 12 (lamp): " before the message of a status that is not OK.
absl::Status located(const absl::Status& status, const std::string& where);

}  // namespace tessera::render
