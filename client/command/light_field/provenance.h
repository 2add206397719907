// How a light field was made, so that lost views can be made again.
#pragma once

#include "absl/status/status.h"
#include "command/render_options.h"
#include "light_field/manifest.h"
#include "tessera/v1/job.pb.h"

namespace tessera::client {

light_field::Provenance provenance_of(const v1::JobSpec& spec, const RenderOptions& options);

/// The scene, its parameters and the settings that were asked for. InvalidArgument where the settings cannot
/// be read.
absl::Status take_provenance(const light_field::Provenance& provenance, RenderOptions& options);

}  // namespace tessera::client
