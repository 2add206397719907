// Standard attributes that say when and how a picture came to be.
#pragma once

#include <cstdint>
#include <ctime>
#include <string>

#include "image/image.h"

namespace tessera::client {

/// Adds "capDate" and "utcOffset" (local time at `now`), "renderingTime" (CPU seconds of the workers, from
/// "tessera.render_seconds"), "comments", where it has none, and "tessera.command_line".
void add_file_facts(const std::string& job_name, std::time_t now, Image& image);

/// Adds "framesPerSecond", and "timeCode" of a frame: SMPTE 12M, counted without dropped frames from 0, of a
/// whole number of frames per second. `shutter`: share of a frame for which things move in the picture, which
/// is its "shutterAngle"; 0: nothing does.
void add_frame_facts(std::int64_t frame, const Rational& frames_per_second, double shutter, Image& image);

}  // namespace tessera::client
