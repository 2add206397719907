#include "measure/annual.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>
#include <utility>

#include "absl/strings/str_cat.h"
#include "import/geometry/transform.h"
#include "measure/receivers.h"
#include "measure/weather_file.h"
#include "photometry/annual/annual_metrics.h"
#include "photometry/annual/sky_patches.h"

namespace tessera::client {

namespace {

using Imath::V3d;
using photometry::SkyPatches;

/// Coefficients are sampled so often: their spread tells the error of metrics.
constexpr std::size_t kYears = 4;
/// Degrees between the rows and columns of a patch's map. All borders of patches lie between two of them.
constexpr int kMapColumns = 720, kMapRows = 180;

/// Numbers of the patches at the texels of a map of all directions; rows from the bottom, as a PFM has them,
/// columns as of LATITUDE_LONGITUDE.
std::vector<std::size_t> patches_of_map(const SkyPatches& patches) {
  std::vector<std::size_t> numbers;
  for (int row = kMapRows - 1; row >= 0; --row) {
    const double polar = (row + 0.5) / kMapRows * std::numbers::pi;
    for (int column = 0; column < kMapColumns; ++column) {
      // In light space y is up, z is north and x is west, which u = 0.25 is.
      const double turn = ((column + 0.5) / kMapColumns - 0.5) * 2 * std::numbers::pi;
      const double west = -std::sin(polar) * std::sin(turn), north = std::sin(polar) * std::cos(turn);
      numbers.push_back(patches.number_of({-west, north, std::cos(polar)}));
    }
  }
  return numbers;
}

/// The map that is 1 in a patch.
std::string map_of_patch(const std::vector<std::size_t>& numbers, std::size_t patch) {
  std::string pfm = absl::StrCat("Pf\n", kMapColumns, " ", kMapRows, "\n-1.0\n");
  std::vector<float> texels(numbers.size());
  std::ranges::transform(numbers, texels.begin(),
                         [&](std::size_t number) { return number == patch ? 1.0f : 0.0f; });
  pfm.append(reinterpret_cast<const char*>(texels.data()), texels.size() * sizeof(float));
  return pfm;
}

v1::Light light_of_sky(double north_degrees, bool y_up) {
  const double turn = north_degrees * std::numbers::pi / 180;
  const V3d up = y_up ? V3d(0, 1, 0) : V3d(0, 0, 1), ahead = y_up ? V3d(0, 0, -1) : V3d(0, 1, 0),
            right = ahead % up;
  const V3d north = ahead * std::cos(turn) + right * std::sin(turn), west = up % north;
  v1::Light light;
  v1::InfiniteLight& sky = *light.mutable_infinite();
  sky.set_mapping(v1::InfiniteLight::LATITUDE_LONGITUDE);
  const std::array<V3d, 3> axes = {west, up, north};
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column)
      sky.mutable_world_from_light()->add_elements(
          row == 3 || column == 3 ? (row == column ? 1 : 0) : axes[static_cast<std::size_t>(column)][row]);
  }
  return light;
}

/// Points and patches of one light, and the numbers of repetitions.
struct Coefficients {
  std::array<std::vector<double>, kYears> by_repetition;  // points x patches
};

struct YearPoint {
  V3d position, normal;
};

/// Probes and the places of their points.
struct YearPlan {
  v1::ProbeCamera camera;
  std::vector<SceneBlob> blobs;
  std::vector<YearPoint> points;
  std::vector<MeasuredPlane> planes;
};

absl::StatusOr<YearPlan> plan_of_year(const v1::AnnualDaylightMeter& meter, const ImportedScene& scene,
                                      const V3d& up) {
  YearPlan plan;
  if (meter.receivers().empty()) return absl::InvalidArgumentError("it has no receivers");
  for (const v1::Receiver& receiver : meter.receivers()) {
    const auto place = place_of(receiver, scene, up);
    if (!place.ok()) return place.status();
    if (place->mesh)
      return absl::InvalidArgumentError("a year is of points, planes and whole surfaces: not by_triangle");
    plan.blobs.insert(plan.blobs.end(), place->blobs.begin(), place->blobs.end());
    v1::Probe& probe = *plan.camera.add_probes();
    probe = place->probe;
    probe.set_kind(v1::Probe::PLANE);
    probe.set_pixels(kYears);
    if (place->plane) {
      plan.planes.push_back(*place->plane);
      plan.planes.back().first_reading = plan.points.size();
    }
    for (const V3d& position : place->positions) plan.points.push_back({position, place->normal});
  }
  return plan;
}

absl::Status fill(const YearPlan& plan, std::size_t patches, std::size_t patch, const std::string& map,
                  ReadLight light, const AnnualSampling& sampling, const v1::Light& sky,
                  const RenderUnderPatch& render, Coefficients& coefficients) {
  ProbeJob job;
  job.camera = plan.camera;
  job.blobs = plan.blobs;
  job.light = light;
  const std::uint64_t pixels = plan.points.size() * kYears;
  job.width = static_cast<std::uint32_t>(std::min<std::uint64_t>(256, pixels));
  job.height = static_cast<std::uint32_t>((pixels + job.width - 1) / job.width);
  job.spp = static_cast<std::uint32_t>(std::bit_floor(std::max<std::uint64_t>(1, sampling.samples / kYears)));
  job.seed = sampling.seed + patch;
  const auto picture = render(job, sky, map);
  if (!picture.ok()) return picture.status();
  std::size_t pixel = 0;
  for (std::size_t point = 0; point < plan.points.size(); ++point) {
    for (std::vector<double>& all : coefficients.by_repetition)
      all[point * patches + patch] = picture->pixels[pixel++][0];
  }
  return absl::OkStatus();
}

/// A metric of points, or of all of them.
struct Metric {
  const char* name;
  const char* quantity;
  const char* unit;
  double factor;
  double photometry::PointMetrics::*of_point;
};
constexpr Metric kMetrics[] = {
    {"DA", "daylight autonomy", "%", 100, &photometry::PointMetrics::daylight_autonomy},
    {"cDA", "continuous daylight autonomy", "%", 100,
     &photometry::PointMetrics::continuous_daylight_autonomy},
    {"UDI < 100 lx", "useful daylight illuminance", "%", 100, &photometry::PointMetrics::udi_low},
    {"UDI 100 to 300 lx", "useful daylight illuminance", "%", 100,
     &photometry::PointMetrics::udi_supplementary},
    {"UDI 300 to 3000 lx", "useful daylight illuminance", "%", 100,
     &photometry::PointMetrics::udi_autonomous},
    {"UDI > 3000 lx", "useful daylight illuminance", "%", 100, &photometry::PointMetrics::udi_exceeded},
    {"mean", "illuminance of occupied hours", "lx", 1, &photometry::PointMetrics::mean_lux}};

/// Mean of the repetitions, with its standard error.
Figure figure_of(const std::array<double, kYears>& values, std::uint64_t samples) {
  double mean = 0, squares = 0;
  for (const double value : values) mean += value / kYears;
  for (const double value : values) squares += (value - mean) * (value - mean);
  return {mean, std::sqrt(squares / (kYears - 1) / kYears), samples, kYears - 1};
}

}  // namespace

absl::StatusOr<std::vector<MeasuredMeter>> measure_year(const v1::AnnualDaylightMeter& meter,
                                                        const std::string& name, const std::string& folder,
                                                        const ImportedScene& scene, bool y_up,
                                                        const AnnualSampling& sampling,
                                                        const RenderUnderPatch& render) {
  const auto weather = read_weather((std::filesystem::path(folder) / meter.weather_file()).string());
  if (!weather.ok()) return weather.status();
  const auto plan = plan_of_year(meter, scene, y_up ? V3d(0, 1, 0) : V3d(0, 0, 1));
  if (!plan.ok()) return plan.status();
  photometry::AnnualOptions options;
  if (meter.has_target_lux()) options.target_lux = meter.target_lux();
  if (meter.has_first_hour()) options.first_hour = meter.first_hour();
  if (meter.has_last_hour()) options.last_hour = meter.last_hour();

  const SkyPatches patches = SkyPatches::tregenza();
  const v1::Light sky = light_of_sky(meter.north_degrees(), y_up);
  Coefficients all, direct;
  for (Coefficients* c : {&all, &direct})
    for (std::vector<double>& values : c->by_repetition) values.resize(plan->points.size() * patches.size());
  const std::vector<std::size_t> numbers = patches_of_map(patches);
  for (std::size_t patch = 0; patch < patches.size(); ++patch) {
    const std::string map = map_of_patch(numbers, patch);
    for (const ReadLight light : {ReadLight::kAll, ReadLight::kStraight}) {
      Coefficients& found = light == ReadLight::kAll ? all : direct;
      if (auto s = fill(*plan, patches.size(), patch, map, light, sampling, sky, render, found); !s.ok())
        return s;
    }
    if (sampling.progress) sampling.progress(patch + 1, patches.size());
  }

  std::array<photometry::AnnualMetrics, kYears> years;
  for (std::size_t k = 0; k < kYears; ++k) {
    auto year = photometry::annual_metrics(
        *weather, patches, {plan->points.size(), all.by_repetition[k], direct.by_repetition[k]}, options);
    if (!year.ok()) return year.status();
    years[k] = *std::move(year);
  }
  const std::uint64_t samples = sampling.samples * patches.size();
  std::vector<MeasuredMeter> result;
  for (const Metric& metric : kMetrics) {
    MeasuredMeter& made = result.emplace_back();
    made.name = absl::StrCat(name, ": ", metric.name), made.quantity = metric.quantity,
    made.unit = metric.unit;
    made.planes = plan->planes;
    for (std::size_t point = 0; point < plan->points.size(); ++point) {
      std::array<double, kYears> values{};
      for (std::size_t k = 0; k < kYears; ++k)
        values[k] = metric.factor * (years[k].points[point].*metric.of_point);
      made.readings.push_back({absl::StrCat(point + 1), plan->points[point].position,
                               plan->points[point].normal, figure_of(values, samples)});
    }
  }
  const auto add_whole = [&](const char* metric, const char* quantity,
                             double photometry::AnnualMetrics::*of_year) {
    MeasuredMeter& made = result.emplace_back();
    made.name = absl::StrCat(name, ": ", metric), made.quantity = quantity, made.unit = "%";
    std::array<double, kYears> values{};
    for (std::size_t k = 0; k < kYears; ++k) values[k] = 100 * (years[k].*of_year);
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    made.readings.push_back({"", V3d(kNone), V3d(0), figure_of(values, samples)});
  };
  add_whole("sDA 300 lx, 50 %", "spatial daylight autonomy",
            &photometry::AnnualMetrics::spatial_daylight_autonomy);
  add_whole("ASE 1000 lx, 250 h", "annual sunlight exposure",
            &photometry::AnnualMetrics::annual_sunlight_exposure);
  if (years[0].hours_without_data > 0)
    result.front().warnings.push_back(absl::StrCat("the weather file has no radiation of ",
                                                   years[0].hours_without_data,
                                                   " occupied hours, which are in no figure"));
  return result;
}

}  // namespace tessera::client
