// Weather files by their paths.
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "photometry/weather/weather.h"

namespace tessera::client {

/// NotFound where there is no such file; InvalidArgument names file, line and column of all that is wrong.
absl::StatusOr<photometry::Weather> read_weather(const std::string& path);

}  // namespace tessera::client
