#include "measure/measure.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <limits>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "measure/ratio.h"

namespace tessera::client {

namespace {

/// Warns of figures that are black, as of meters within walls.
void warn_of_black(MeasuredMeter& meter) {
  std::size_t black = 0;
  for (const Reading& reading : meter.readings)
    black +=
        reading.figure.value == 0 && reading.figure.standard_error == 0 && reading.figure.samples > 0 ? 1 : 0;
  // Some sides of a surface may well be dark.
  if (black == 0 || (!meter.meshes.empty() && black < meter.readings.size())) return;
  const std::string who = black == meter.readings.size()
                              ? std::string("no light at all reaches it")
                              : absl::StrCat(black, " of its ", meter.readings.size(), " figures are 0");
  meter.warnings.push_back(
      absl::StrCat(who, ": is it within something solid, or does it look the wrong way?"));
}

void warn_of_heavy_tails(const PlannedMeter& planned, const SampledCells& sampled, MeasuredMeter& meter) {
  std::size_t heavy = 0;
  for (const PlannedReading& reading : planned.readings) heavy += has_heavy_tail(reading, sampled) ? 1 : 0;
  if (heavy == 0) return;
  meter.warnings.push_back(absl::StrCat(heavy, " of its ", meter.readings.size(),
                                        " figures rest on few bright paths: their errors may be larger than "
                                        "is told; more --samples, or another "
                                        "integrator, help"));
}

/// Makes figures of a plan.
class Measurer {
 public:
  Measurer(const MeasuredScene& scene, const MeterFile& file, const SamplingOptions& options,
           const MeasureRenderers& renderers)
      : scene_(scene), file_(file), options_(options), renderers_(renderers) {}

  /// The meters of one that is read of pictures, or of a year.
  absl::StatusOr<std::vector<MeasuredMeter>> measure_apart(const PlannedMeter& planned) const;

 private:
  absl::StatusOr<std::vector<MeasuredMeter>> measure_part_of_picture(const PlannedMeter& planned,
                                                                     const v1::RadianceMeter& meter) const;

  /// Pictures of different meters have seeds far apart: their errors are independent.
  PictureSampling picture_sampling(const PlannedMeter& planned) const {
    const auto number = static_cast<std::uint64_t>(*planned.apart);
    return {.samples = options_.samples,
            .seed = options_.seed + ((number + 1) << 40),
            .cd_per_m2 = scene_.cd_per_m2};
  }

  const MeasuredScene& scene_;
  const MeterFile& file_;
  const SamplingOptions& options_;
  const MeasureRenderers& renderers_;
};

absl::StatusOr<std::vector<MeasuredMeter>> Measurer::measure_part_of_picture(
    const PlannedMeter& planned, const v1::RadianceMeter& meter) const {
  const auto figure = measure_area(meter.area(), scene_.picture, planned.factor, picture_sampling(planned),
                                   renderers_.picture);
  if (!figure.ok()) return figure.status();
  MeasuredMeter made;
  made.name = planned.name, made.quantity = planned.quantity, made.unit = planned.unit;
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  made.readings.push_back({"", Imath::V3d(kNone), Imath::V3d(0), *figure});
  return std::vector{std::move(made)};
}

absl::StatusOr<std::vector<MeasuredMeter>> Measurer::measure_apart(const PlannedMeter& planned) const {
  const v1::Meter& meter = file_.list.meters(*planned.apart);
  const bool y_up = file_.list.up() == v1::MeterList::Y;
  switch (meter.kind_case()) {
    case v1::Meter::kGlare:
      return measure_glare(meter.glare(), planned.name, y_up, picture_sampling(planned), renderers_.picture);
    case v1::Meter::kAnnualDaylight: {
      const std::string folder = std::filesystem::path(file_.path).parent_path().string();
      return measure_year(meter.annual_daylight(), planned.name, folder, scene_.imported, y_up,
                          {.samples = options_.samples, .seed = options_.seed}, renderers_.under_patch);
    }
    default:
      return measure_part_of_picture(planned, meter.radiance());
  }
}

/// The figures of a plan's meter by what its cells have read.
MeasuredMeter read_cells(const PlannedMeter& planned, const SampledCells& sampled, bool is_night) {
  MeasuredMeter meter;
  meter.name = planned.name, meter.quantity = planned.quantity, meter.unit = planned.unit;
  meter.planes = planned.planes, meter.meshes = planned.meshes, meter.warnings = planned.warnings;
  for (const PlannedReading& reading : planned.readings)
    meter.readings.push_back({reading.label, reading.position, reading.normal, figure_of(reading, sampled)});
  if (!is_night) warn_of_black(meter);
  warn_of_heavy_tails(planned, sampled, meter);
  return meter;
}

/// The figures of a meter over those of another.
MeasuredMeter divide(const PlannedMeter& planned, const MeasuredMeter& of, const MeasuredMeter& over,
                     bool is_night) {
  MeasuredMeter meter;
  meter.name = planned.name, meter.quantity = planned.quantity, meter.unit = planned.unit;
  meter.planes = of.planes, meter.meshes = of.meshes;
  std::size_t without = 0;
  for (std::size_t i = 0; i < of.readings.size(); ++i) {
    const Figure& below = over.readings[partner_of(i, over.readings.size())].figure;
    Reading& reading = meter.readings.emplace_back(of.readings[i]);
    reading.figure = ratio_of(of.readings[i].figure, below, planned.ratio->kind);
    without += std::isnan(reading.figure.value) && !std::isnan(of.readings[i].figure.value) ? 1 : 0;
  }
  if (without > 0 && !is_night) meter.warnings.push_back(absl::StrCat(without, " of its figures are over 0"));
  return meter;
}

void note_worst(double error, const std::string& meter, Measured& result) {
  if (error > result.worst_error) result.worst_error = error, result.worst_meter = meter;
}

void find_worst(const MeasurePlan& plan, const SampledCells& sampled, Measured& result) {
  for (const PlannedMeter& meter : plan.meters) {
    for (const PlannedReading& reading : meter.readings)
      note_worst(relative_error(reading, sampled), meter.name, result);
  }
}

/// Pictures and years take the samples that they are told to, whatever error is wanted: ratios of them may
/// lack some.
void judge_ratio(const PlannedMeter& planned, double wanted, MeasuredMeter& meter, Measured& result) {
  double worst = 0;
  for (const Reading& reading : meter.readings)
    worst = std::max(worst, relative_error_of_ratio(reading.figure, planned.ratio->kind));
  note_worst(worst, planned.name, result);
  if (wanted > 0 && worst > wanted)
    meter.warnings.push_back(absl::StrFormat(
        "it is within %.2g %%, not %.2g %%: areas of the picture take --samples", 100 * worst, 100 * wanted));
}

/// The integrator of a meter, or of both that a ratio is of; empty for closed forms.
std::string integrators_of(const MeasurePlan& plan, std::size_t meter, const std::string& usual,
                           const SampledCells& sampled, const SamplingOptions& options) {
  const auto has_terms = [](const PlannedReading& reading) { return !reading.terms.empty(); };
  const std::vector<PlannedReading>& readings = plan.meters[meter].readings;
  if (!readings.empty() && std::ranges::none_of(readings, has_terms)) return "";
  if (sampled.integrator_of_meter.empty()) return usual;
  const auto name_of = [&](std::size_t m) { return options.integrators[sampled.integrator_of_meter[m]]; };
  const std::optional<PlannedRatio>& ratio = plan.meters[meter].ratio;
  if (!ratio) return name_of(meter);
  const std::string of = name_of(ratio->of), over = name_of(ratio->over);
  return of == over ? of : absl::StrCat(of, ", ", over);
}

}  // namespace

absl::StatusOr<MeasureRun> measure(const MeasurePlan& plan, const MeasuredScene& scene, const MeterFile& file,
                                   const std::string& algorithm, const SamplingOptions& options,
                                   const MeasureRenderers& renderers) {
  const auto sampled = sample_cells(plan, options, renderers.probes);
  if (!sampled.ok()) return sampled.status();
  MeasureRun run;
  run.stopped = sampled->stopped;
  Measured& result = run.measured;
  result.scene = scene.imported.file;
  result.meters_file = file.path;
  result.metres_per_unit = scene.metres;
  result.wanted_error = options.error;
  result.cpu_seconds = sampled->cpu_seconds;
  result.seed = options.seed;
  find_worst(plan, *sampled, result);
  const Measurer measurer(scene, file, options, renderers);
  std::vector<std::vector<MeasuredMeter>> by_planned(plan.meters.size());
  for (const bool years : {false, true}) {
    for (std::size_t i = 0; i < plan.meters.size(); ++i) {
      const PlannedMeter& planned = plan.meters[i];
      const bool is_year = planned.apart && file.list.meters(*planned.apart).has_annual_daylight();
      if (is_year != years || planned.ratio) continue;
      if (!planned.apart) {
        by_planned[i] = {read_cells(planned, *sampled, scene.is_night)};
        continue;
      }
      auto made = measurer.measure_apart(planned);
      if (!made.ok())
        return absl::Status(made.status().code(), absl::StrCat(planned.name, ": ", made.status().message()));
      by_planned[i] = *std::move(made);
    }
  }
  for (std::size_t i = 0; i < plan.meters.size(); ++i) {
    const PlannedMeter& planned = plan.meters[i];
    if (!planned.ratio) continue;
    by_planned[i] = {divide(planned, by_planned[planned.ratio->of].front(),
                            by_planned[planned.ratio->over].front(), scene.is_night)};
    judge_ratio(planned, run.stopped ? 0 : options.error, by_planned[i].front(), result);
  }
  for (std::size_t i = 0; i < plan.meters.size(); ++i) {
    for (MeasuredMeter& meter : by_planned[i]) {
      meter.algorithm = integrators_of(plan, i, algorithm, *sampled, options);
      result.meters.push_back(std::move(meter));
    }
  }
  return run;
}

}  // namespace tessera::client
