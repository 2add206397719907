// An animation: one job a frame.
#pragma once

#include <cstdint>
#include <functional>
#include <stop_token>

#include "command/render_options.h"

namespace tessera::client {

/// Defines --frames and what goes with it.
void define_frame_options(options::Command& command, RenderOptions& options);

/// InvalidArgument when frames would be written over each other, or options do not go together.
absl::Status check_frames(const RenderOptions& options);

/// The options of one frame: the one place that knows where frames come from and go to. Files have its number
/// in place of ####, parameters of the scene in place of {frame}, the time of glTF's animations follows from
/// it, and load_job() poses what the scene's own keys move.
RenderOptions options_of_frame(const RenderOptions& all, std::int64_t frame);

/// The rest of the work on a frame that has been started; returns its exit code.
using FrameJob = std::function<int()>;
/// Starts a frame. Null, with the exit code set, where that does not work.
using StartFrame = std::function<FrameJob(const RenderOptions& frame, int& exit_code)>;

/// Renders all frames: at most `ahead` are started before the first of them is finished. Frames that are
/// there already are left out where that is asked for; those that fail do not keep the others from being
/// rendered, are listed at the end, and make the exit code kFramesFailed, or kNotDenoised where that is all
/// that some lack. Usage and an unreachable coordinator end it. `deed`: what was done with a frame whose job
/// is over.
int run_frames(const RenderOptions& options, std::size_t ahead, const StartFrame& start, std::stop_token stop,
               const char* deed = "rendered");

}  // namespace tessera::client
