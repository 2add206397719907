// A loaded scene rendered in this process, on all cores.
#pragma once

#include "image/image.h"
#include "support/scene_file.h"

namespace tessera::test {

/// The whole film with the job's samples and AOVs. Dropped samples and failed tiles are failures of the
/// running test; the image is empty then.
client::Image render_image(const LoadedFile& file);

}  // namespace tessera::test
