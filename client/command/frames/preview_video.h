// A film of all frames, to look at: by ffmpeg, where it is installed.
#pragma once

#include <stop_token>

#include "command/render_options.h"

namespace tessera::client {

/// InvalidArgument for another kind of film, or where there is no ffmpeg, before anything is rendered.
absl::Status check_preview_video(const RenderOptions& options);

/// Writes the film of the frames that --frames names, in ascending order; returns the exit code.
int write_preview_video(const RenderOptions& options, std::stop_token stop);

}  // namespace tessera::client
