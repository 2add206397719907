#include "measure/plan.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "measure/fault.h"
#include "measure/light_unit.h"
#include "measure/planner.h"
#include "measure/receivers.h"
#include "photometry/units/light_unit.h"

namespace tessera::client {

using Imath::V3d;

absl::Status Planner::begin(const v1::Meter& meter, LightQuantity quantity) {
  const auto unit = unit_of(meter.unit(), quantity, scene_.cd_per_m2, scene_.is_spectral);
  if (!unit.ok()) return unit.status();
  factor_ = unit->factor, channel_ = unit->channel;
  PlannedMeter& added = plan_.meters.emplace_back();
  added.name = meter.name().empty() ? absl::StrCat("meter ", plan_.meters.size()) : meter.name();
  added.quantity = unit->quantity, added.unit = unit->name;
  return absl::OkStatus();
}

std::size_t Planner::add_probe(const ReceiverPlace& place, v1::Probe::Kind kind, ReadLight light) {
  PlannedProbe& added = plan_.probes.emplace_back();
  added.probe = place.probe;
  added.probe.set_kind(kind);
  added.light = light;
  added.first_cell = plan_.cells;
  added.cells = place.positions.size();
  added.blobs = place.blobs, added.triangles = place.triangles;
  plan_.cells += added.cells;
  return added.first_cell;
}

PlannedReading& Planner::add_reading(std::string label) {
  PlannedReading& reading = plan_.meters.back().readings.emplace_back();
  reading.label = std::move(label);
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  reading.position = V3d(kNone);
  return reading;
}

void Planner::add_cells(const ReceiverPlace& place, std::size_t first_cell, double factor,
                        std::optional<std::size_t> over) {
  PlannedMeter& meter = plan_.meters.back();
  if (place.plane) {
    meter.planes.push_back(*place.plane);
    meter.planes.back().first_reading = meter.readings.size();
  }
  if (place.mesh) {
    meter.meshes.push_back(*place.mesh);
    meter.meshes.back().first_reading = meter.readings.size();
  }
  const auto label_of = [&](std::size_t cell) {
    if (place.mesh) return absl::StrCat(cell);
    if (!place.plane) return absl::StrCat(meter.readings.size() + 1);
    return absl::StrCat(cell % place.plane->columns + 1, " ", cell / place.plane->columns + 1);
  };
  for (std::size_t cell = 0; cell < place.positions.size(); ++cell) {
    PlannedReading& reading = add_reading(label_of(cell));
    reading.position = place.positions[cell], reading.normal = place.normal;
    if (place.mesh) {
      const CellTriangle& triangle = place.triangles[cell];
      if (!(triangle.area() > 0)) {
        reading.constant = std::numeric_limits<double>::quiet_NaN();
        continue;
      }
      reading.normal = (triangle.edge_u % triangle.edge_v).normalized() * (place.probe.inward() ? -1.0 : 1.0);
    }
    reading.terms = {{first_cell + cell, factor, channel_}};
    reading.over = over;
  }
}

absl::Status Planner::add_radiance(const v1::RadianceMeter& meter) {
  if (meter.has_area()) return set_apart();
  if (!meter.has_ray()) return fault("it has neither a ray nor an area of the picture");
  const V3d from = vector_of(meter.ray().from()), way = vector_of(meter.ray().toward()) - from;
  if (!(way.length() > 0) || !std::isfinite(way.length())) return fault("its ray has no direction");
  ReceiverPlace place;
  place.positions = {from};
  place.normal = way.normalized();
  *place.probe.mutable_point() = meter.ray().from();
  *place.probe.mutable_axis() = point_of(place.normal);
  place.probe.set_field_degrees(meter.ray().field_degrees());
  add_cells(place, add_probe(place, v1::Probe::CONE), factor_);
  return absl::OkStatus();
}

absl::Status Planner::set_apart() {
  PlannedMeter& meter = plan_.meters.back();
  meter.apart = number_, meter.factor = factor_;
  return absl::OkStatus();
}

namespace {

v1::Probe::Kind probe_kind_of(v1::IrradianceMeter::Shape shape) {
  switch (shape) {
    case v1::IrradianceMeter::SPHERE:
      return v1::Probe::SPHERE;
    case v1::IrradianceMeter::CYLINDER:
      return v1::Probe::CYLINDER;
    case v1::IrradianceMeter::HALF_CYLINDER:
      return v1::Probe::HALF_CYLINDER;
    case v1::IrradianceMeter::HALF_SPHERE:
      return v1::Probe::HALF_SPHERE;
    default:
      return v1::Probe::PLANE;
  }
}

}  // namespace

absl::Status Planner::add_irradiance(const v1::IrradianceMeter& meter) {
  return for_each_place(meter.receivers(), [&](ReceiverPlace& place) {
    if (meter.shape() == v1::IrradianceMeter::HALF_CYLINDER) {
      if (!meter.has_front()) return fault("semicylindrical irradiance needs a front");
      *place.probe.mutable_front() = meter.front();
    }
    add_cells(place, add_probe(place, probe_kind_of(meter.shape())), factor_);
    return absl::OkStatus();
  });
}

absl::Status Planner::add_light_vector(const v1::LightVectorMeter& meter) {
  const V3d axes[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const char* const names[] = {"x", "y", "z"};
  return for_each_place(meter.receivers(), [&](ReceiverPlace& place) {
    if (!place.probe.has_point()) return fault("the light vector is of points");
    for (int a = 0; a < 3; ++a) {
      PlannedReading& reading = add_reading(names[a]);
      reading.position = place.positions.front(), reading.normal = axes[a];
      for (const double sign : {1.0, -1.0}) {
        *place.probe.mutable_axis() = point_of(axes[a] * sign);
        reading.terms.push_back({add_probe(place, v1::Probe::PLANE), sign * factor_, channel_});
      }
    }
    return absl::OkStatus();
  });
}

absl::Status Planner::add_exitance(const v1::ExitanceMeter& meter) {
  return for_each_place(meter.receivers(), [&](ReceiverPlace& place) {
    if (place.probe.has_point()) return fault("what leaves a surface is read on planes and surfaces");
    if (!(place.probe.offset() > 0)) return fault("what leaves a surface is read from an offset above 0");
    add_cells(place, add_probe(place, v1::Probe::EXITANCE), factor_);
    return absl::OkStatus();
  });
}

absl::Status Planner::add_daylight_factor(const v1::DaylightFactorMeter& meter) {
  auto ball = scene_.ball();
  if (!ball.ok()) return ball.status();
  ReceiverPlace outdoors;
  outdoors.positions = {ball->middle + up_ * (2 * ball->radius)};
  *outdoors.probe.mutable_point() = point_of(outdoors.positions.front());
  *outdoors.probe.mutable_axis() = point_of(up_);
  const std::size_t over = add_probe(outdoors, v1::Probe::PLANE, ReadLight::kStraight);
  const ReadLight light =
      meter.part() == v1::DaylightFactorMeter::SKY_COMPONENT ? ReadLight::kStraight : ReadLight::kAll;
  constexpr double kPercent = 100;
  return for_each_place(meter.receivers(), [&](ReceiverPlace& place) {
    add_cells(place, add_probe(place, v1::Probe::PLANE, light), kPercent, over);
    return absl::OkStatus();
  });
}

absl::Status Planner::add(int number) {
  number_ = number;
  const v1::Meter& meter = list_.meters(number);
  const auto begun = [&](LightQuantity quantity, auto&& added) -> absl::Status {
    if (absl::Status s = begin(meter, quantity); !s.ok()) return s;
    return added();
  };
  switch (meter.kind_case()) {
    case v1::Meter::kRadiance:
      return begun(LightQuantity::kRadiance, [&] { return add_radiance(meter.radiance()); });
    case v1::Meter::kIrradiance:
      return begun(LightQuantity::kIrradiance, [&] { return add_irradiance(meter.irradiance()); });
    case v1::Meter::kLightVector:
      return begun(LightQuantity::kIrradiance, [&] { return add_light_vector(meter.light_vector()); });
    case v1::Meter::kExitance:
      return begun(LightQuantity::kExitance, [&] { return add_exitance(meter.exitance()); });
    case v1::Meter::kIntensity:
      return begun(LightQuantity::kIntensity, [&] { return add_intensity(meter.intensity()); });
    case v1::Meter::kFlux:
      return begun(LightQuantity::kFlux, [&] { return add_flux(meter.flux()); });
    case v1::Meter::kEnergyBalance:
      return begun(LightQuantity::kFlux, [&] { return add_energy_balance(); });
    case v1::Meter::kDaylightFactor:
      return begun(LightQuantity::kDaylightFactor,
                   [&] { return add_daylight_factor(meter.daylight_factor()); });
    case v1::Meter::kAnnualDaylight:
      return begun(LightQuantity::kIrradiance, [&] { return set_apart(); });
    case v1::Meter::kGlare:
      return begun(LightQuantity::kRadiance, [&] { return set_apart(); });
    case v1::Meter::kRatio:
      if (!meter.unit().empty()) return fault("a ratio has no unit");
      return begun(LightQuantity::kRadiance, [&] { return add_ratio(meter.ratio()); });
    case v1::Meter::KIND_NOT_SET:
      break;
  }
  return fault("it says nothing of what it measures");
}

absl::StatusOr<MeasuredScene> measured_scene(const ImportedScene& imported, const MeterFile& file,
                                             bool is_spectral, std::function<absl::StatusOr<Ball>()> ball) {
  v1::Scene picture;
  *picture.mutable_camera() = imported.scene.camera();
  *picture.mutable_film() = imported.scene.film();
  MeasuredScene scene{.imported = imported,
                      .is_spectral = is_spectral,
                      .picture = std::move(picture),
                      .ball = std::move(ball)};
  const v1::SceneUnits& units = imported.scene.units();
  scene.metres = units.metres();
  if (units.cd_per_m2() > 0) scene.cd_per_m2 = units.cd_per_m2();
  if (file.list.unit().empty()) return scene;
  const auto metres = photometry::parse_length_unit(file.list.unit());
  if (!metres.ok())
    return absl::InvalidArgumentError(absl::StrCat(file.path, ": ", metres.status().message()));
  if (scene.metres > 0 && std::abs(scene.metres / *metres - 1) > 1e-6)
    return absl::InvalidArgumentError(absl::StrCat(file.path, ": the meters' unit is ", *metres,
                                                   " m long, the scene's ", scene.metres, " m"));
  scene.metres = *metres;
  return scene;
}

absl::StatusOr<MeasurePlan> plan_of(const MeterFile& file, const MeasuredScene& scene) {
  constexpr std::size_t kMostCells = std::size_t{1} << 24;
  Planner planner(file, scene);
  std::vector<std::pair<std::size_t, std::string>> faults;
  for (int i = 0; i < file.list.meters_size(); ++i) {
    const absl::Status added = planner.add(i);
    if (absl::IsResourceExhausted(added)) return added;
    if (!added.ok()) faults.emplace_back(static_cast<std::size_t>(i), std::string(added.message()));
    if (planner.cells() > kMostCells)
      return absl::ResourceExhaustedError(absl::StrCat(file.path, ": its meters have more than ", kMostCells,
                                                       " cells: coarser planes take less memory"));
  }
  for (int i = 0; faults.empty() && i < file.list.meters_size(); ++i) {
    if (const absl::Status s = planner.check_ratio(i); !s.ok())
      faults.emplace_back(static_cast<std::size_t>(i), std::string(s.message()));
  }
  if (absl::Status s = file.status_of(faults); !s.ok()) return s;
  return planner.take();
}

}  // namespace tessera::client
