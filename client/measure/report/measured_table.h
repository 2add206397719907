// Measured figures as tables: for people, as CSV and as JSON (docs/measuring-reports.md).
#pragma once

#include <string>

#include "measure/measured.h"

namespace tessera::client {

struct MeasuredTextOptions {
  bool all_cells = false;  // of planes, too, which have one line for all otherwise
};

/// A heading and a line for each reading, and one for each plane with its mean, least and largest value and
/// uniformities U0 and U1; then warnings, and the error that was asked for and reached.
std::string measured_text(const Measured& measured, const MeasuredTextOptions& options = {});

/// The same, with a column of steps before the others: "11", "5 (night)".
std::string measured_text(const MeasuredSeries& series, const MeasuredTextOptions& options = {});

/// Records of RFC 4180, the first with names: "meter", "quantity", "unit", "label", "x", "y", "z", "nx",
/// "ny", "nz", "value", "standard_error", "low95", "high95", "samples", "integrator". Numbers are the
/// shortest that read as the same double; places and normals that there are not are empty.
std::string measured_csv(const Measured& measured);

/// Before these, each record has the step, in a column of the series' name, "sky" (its word) and
/// "sun_altitude" (degrees; empty where there is none).
std::string measured_csv(const MeasuredSeries& series);

/// The same and what Measured has besides, nested: "meters" with "readings" and "planes". Numbers that are
/// not finite, and places that there are not, are null.
std::string measured_json(const Measured& measured);

/// "series" with its name, and "steps", each of which has the step by that name, "sky",
/// "sun_altitude_degrees", and all that is written of a Measured.
std::string measured_json(const MeasuredSeries& series);

}  // namespace tessera::client
