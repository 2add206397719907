// Cameras with a hole instead of a lens, for the kernels.
#pragma once

#include <memory>

#include "absl/status/status.h"
#include "render/sensor/hole_table.h"
#include "tessera/v1/camera.pb.h"

namespace tessera::render {

/// InvalidArgument with all that is wrong with the hole and its film.
absl::Status check_hole(const v1::PinholeCamera& camera);

/// The hole of a camera that has been checked. `spectral`: for wavelengths of their own; else for the
/// camera's one.
std::shared_ptr<const HoleTable> hole_table(const v1::PinholeCamera& camera, bool spectral);

}  // namespace tessera::render
