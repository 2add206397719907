// A measured plane in few numbers, and as values on a grid; of a measured surface the numbers.
#pragma once

#include <cstddef>
#include <string>

#include "absl/status/statusor.h"
#include "measure/measured.h"
#include "plot/isolines.h"

namespace tessera::client {

/// Readings of the plane's cells, from `first_reading` on. InvalidArgument, naming the meter, where the meter
/// has fewer.
absl::StatusOr<ValueGrid> grid_of(const MeasuredMeter& meter, const MeasuredPlane& plane);

/// The standard errors of the same cells.
ValueGrid errors_of(const MeasuredMeter& meter, const MeasuredPlane& plane);

struct PlaneSummary {
  std::size_t cells = 0;    // with a finite value
  std::size_t missing = 0;  // without
  // Mean of the cells, which are weighed by their areas; its error is that of independent cells. Samples are
  // those of all, degrees of freedom by [Satterthwaite1946].
  Figure mean;
  double least = 0, most = 0;
  double uniformity_mean = 0;  // U0: least / mean
  double uniformity_most = 0;  // U1: least / most
  double worst_error = 0;      // largest standard error of a cell over its value
};

/// Least or largest value with the digits that the cells' errors let it have.
std::string extreme_text(const PlaneSummary& summary, double value);

/// The plane's cells are within the meter's readings (grid_of).
PlaneSummary summary_of(const MeasuredMeter& meter, const MeasuredPlane& plane);
PlaneSummary summary_of(const MeasuredMeter& meter, const MeasuredMesh& mesh);

/// Whether the triangles are within the meter's readings.
bool is_within(const MeasuredMeter& meter, const MeasuredMesh& mesh);

/// Sides in metres, or in units of the scene where the unit is not said.
struct PlaneSize {
  double width = 0, height = 0;
  std::string unit;
};
PlaneSize size_of(const MeasuredPlane& plane, double metres_per_unit);

/// Whether a reading belongs to a plane or a surface of its meter.
bool is_of_map(const MeasuredMeter& meter, std::size_t reading);

}  // namespace tessera::client
