// A series: the same meters under one sky after another.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "import/input/imported_scene.h"
#include "measure/meter_file.h"

namespace tessera::client {

/// A sky of a series.
struct SkyStep {
  double value = 0;  // what the series goes by: an hour, or a CIE type
  /// "day", the name of a CIE sky, "all-weather"; "night" where the sun is below the horizon: the sky is
  /// black then, whatever its model.
  std::string word;
  double sun_altitude_degrees = 0;  // NaN where nobody says where the sun is
  v1::SkyLight sky;
};

struct SkySteps {
  std::string name;  // "hour" or "cie_type"
  int light = 0;     // of the scene's lights, whose sky is replaced
  std::vector<SkyStep> steps;
};

/// The skies of a file that has a series. InvalidArgument, with file and line, where the scene has no sky or
/// several, a meter goes with no series, the series has no steps or more than 1000, or a sky is at fault;
/// errors of read_weather() else.
absl::StatusOr<SkySteps> sky_steps(const MeterFile& file, const ImportedScene& scene);

}  // namespace tessera::client
