// Names of what the item buffer (AOV id) numbers.
#pragma once

#include "image/image.h"
#include "tessera/v1/job.pb.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::client {

/// Where the job has the AOV id, adds the attributes "tessera.shapes" and "tessera.instances": objects of
/// JSON with the names of shapes, and of what instances place, by number. Those without a name are left out;
/// so is an attribute of more than a mebibyte.
void add_item_names(const v1::Scene& scene, const v1::JobSpec& spec, Image& image);

}  // namespace tessera::client
