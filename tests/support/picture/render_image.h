// A loaded scene rendered in this process, on all cores.
#pragma once

#include <cstdint>

#include "image/image.h"
#include "support/picture/scene_file.h"

namespace tessera::test {

/// The whole film with the job's samples and AOVs. Dropped samples and failed tiles are failures of the
/// running test; the image is empty then. `seed_offset` is added to the job's seed; `prepared` is what the
/// phases made of an algorithm that has any (support/picture/phases.h).
client::Image render_image(const LoadedFile& file, std::uint64_t seed_offset = 0,
                           const render::Prepared* prepared = nullptr);

}  // namespace tessera::test
