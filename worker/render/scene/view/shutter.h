// How a camera's film is exposed, for the kernels.
#pragma once

#include <memory>

#include "absl/status/statusor.h"
#include "render/film/sample_source.h"
#include "render/sensor/shutter_table.h"
#include "tessera/v1/camera.pb.h"

namespace tessera::render {

/// Null for one that is open from 0 to 1, for all of the film. InvalidArgument tells all that is wrong.
absl::StatusOr<std::shared_ptr<const ShutterTable>> build_shutter(const v1::Shutter& shutter, FilmSize film);

}  // namespace tessera::render
