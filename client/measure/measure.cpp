#include "measure/measure.h"

#include <cmath>

#include "absl/strings/str_cat.h"

namespace tessera::client {

namespace {

/// Warns of figures that are black, as of meters within walls.
void warn_of_black(MeasuredMeter& meter) {
  std::size_t black = 0;
  for (const Reading& reading : meter.readings)
    black += reading.figure.value == 0 && reading.figure.samples > 0 ? 1 : 0;
  if (black == 0) return;
  meter.warnings.push_back(absl::StrCat(
      black == meter.readings.size() ? "no"
                                     : absl::StrCat(black, " of its ", meter.readings.size(), " figures"),
      black == meter.readings.size() ? " light at all reaches it" : " are 0",
      ": is it within something solid, or does it look the wrong way?"));
}

}  // namespace

absl::StatusOr<Measured> measure(const MeasurePlan& plan, const MeasuredScene& scene, const MeterFile& file,
                                 const std::string& algorithm, const SamplingOptions& options,
                                 const RenderProbes& render, bool& stopped) {
  const auto sampled = sample_cells(plan, options, render);
  if (!sampled.ok()) return sampled.status();
  stopped = sampled->stopped;
  Measured result;
  result.scene = scene.imported.file;
  result.meters_file = file.path;
  result.metres_per_unit = scene.metres;
  result.wanted_error = options.error;
  result.cpu_seconds = sampled->cpu_seconds;
  result.seed = options.seed;
  for (const PlannedMeter& planned : plan.meters) {
    MeasuredMeter& meter = result.meters.emplace_back();
    meter.name = planned.name, meter.quantity = planned.quantity, meter.unit = planned.unit;
    meter.algorithm = algorithm;
    meter.planes = planned.planes, meter.warnings = planned.warnings;
    for (const PlannedReading& reading : planned.readings) {
      const Figure figure = figure_of(reading, *sampled);
      meter.readings.push_back({reading.label, reading.position, reading.normal, figure});
      if (const double error = relative_error(figure); reading.is_judged && error > result.worst_error) {
        result.worst_error = error;
        result.worst_meter = meter.name;
      }
    }
    warn_of_black(meter);
  }
  return result;
}

}  // namespace tessera::client
