// Apertures of pbrt's camera "realistic" that are not round.
#pragma once

#include <string>

#include "import/pbrt/context.h"

namespace tessera::client::pbrt {

/// The picture of an aperture: of the names that pbrt-v4 has ("gaussian", "square", "pentagon", "star"), or
/// an image file; as bright as a circle. An error names `where`, and a reference
/// without a digest is returned.
v1::BlobRef aperture_picture(Context& context, const std::string& name, SourceLocation where);

}  // namespace tessera::client::pbrt
