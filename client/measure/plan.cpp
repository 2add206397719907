#include "measure/plan.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "absl/strings/str_cat.h"
#include "measure/fault.h"
#include "measure/light_unit.h"
#include "measure/receivers.h"
#include "photometry/units/light_unit.h"

namespace tessera::client {

namespace {

using Imath::V3d;
constexpr double kPi = std::numbers::pi;

/// Makes the probes and readings of meters.
class Planner {
 public:
  Planner(const MeterFile& file, const MeasuredScene& scene)
      : list_(file.list), scene_(scene), up_(list_.up() == v1::MeterList::Y ? V3d(0, 1, 0) : V3d(0, 0, 1)) {}

  /// Adds the meter of this number in the file.
  absl::Status add(int number);
  MeasurePlan take() { return std::move(plan_); }
  std::size_t cells() const { return plan_.cells; }

 private:
  absl::Status add_radiance(const v1::RadianceMeter& meter);
  absl::Status add_irradiance(const v1::IrradianceMeter& meter);
  absl::Status add_light_vector(const v1::LightVectorMeter& meter);
  absl::Status add_exitance(const v1::ExitanceMeter& meter);
  absl::Status add_intensity(const v1::IntensityMeter& meter);
  absl::Status add_flux(const v1::FluxMeter& meter);
  absl::Status add_daylight_factor(const v1::DaylightFactorMeter& meter);
  absl::Status add_energy_balance();
  absl::Status set_apart();

  /// Names what the meter measures in the unit that it asks for, and keeps the factor from radiance.
  absl::Status begin(const v1::Meter& meter, LightQuantity quantity);
  /// Adds a probe; returns the number of its first cell.
  std::size_t add_probe(const ReceiverPlace& place, v1::Probe::Kind kind, ReadLight light = ReadLight::kAll);
  /// Adds a reading for each cell of a place.
  void add_cells(const ReceiverPlace& place, std::size_t first_cell, double factor,
                 std::optional<std::size_t> over = std::nullopt);
  PlannedReading& add_reading(std::string label);
  template <class Receivers, class F>
  absl::Status for_each_place(const Receivers& receivers, F&& f);
  /// Adds to a reading the flux that arrives at a surface, or leaves it.
  void add_flux_of(const ReceiverPlace& place, v1::Probe::Kind kind, double sign, PlannedReading& reading,
                   ReadLight light = ReadLight::kAll);
  /// Square metres of the scene's unit squared; a warning where its length is not said.
  double square_metres();
  absl::StatusOr<ReceiverPlace> hull(bool inward);

  const v1::MeterList& list_;
  const MeasuredScene& scene_;
  const V3d up_;
  MeasurePlan plan_;
  int number_ = 0;  // of the meter that is added
  // From what cells read to the meter's unit.
  double factor_ = 1;
  ReadingChannel channel_ = ReadingChannel::kLuminance;
};

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
  const std::size_t columns = place.plane ? place.plane->columns : 1;
  for (std::size_t cell = 0; cell < place.positions.size(); ++cell) {
    PlannedReading& reading =
        add_reading(place.plane ? absl::StrCat(cell % columns + 1, " ", cell / columns + 1)
                                : absl::StrCat(meter.readings.size() + 1));
    reading.position = place.positions[cell], reading.normal = place.normal;
    reading.terms = {{first_cell + cell, factor, channel_}};
    reading.over = over;
  }
}

template <class Receivers, class F>
absl::Status Planner::for_each_place(const Receivers& receivers, F&& f) {
  if (receivers.empty()) return fault("it has no receivers");
  for (const v1::Receiver& receiver : receivers) {
    auto place = place_of(receiver, scene_.imported, up_);
    if (!place.ok()) return place.status();
    if (absl::Status s = f(*place); !s.ok()) return s;
  }
  return absl::OkStatus();
}

double Planner::square_metres() {
  if (scene_.metres > 0) return scene_.metres * scene_.metres;
  plan_.meters.back().warnings.emplace_back(
      "neither the scene nor the meters say how long the scene's unit is: it is taken for a metre");
  return 1;
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

absl::Status Planner::add_intensity(const v1::IntensityMeter& meter) {
  const double square = square_metres();
  for (const v1::Light& light : scene_.imported.scene.lights()) {
    if (light.has_infinite() || light.has_sky() || light.has_distant())
      return fault("the intensity of a scene with a sky or a sun has no end: its lights shine from infinity");
  }
  auto ball = scene_.ball();
  if (!ball.ok()) return ball.status();
  const V3d middle = meter.has_middle() ? vector_of(meter.middle()) : ball->middle;
  const double radius = ball->radius + (middle - ball->middle).length();
  const V3d axis = (meter.has_axis() ? vector_of(meter.axis()) : -up_).normalized();
  V3d c0 = meter.has_c0() ? vector_of(meter.c0()) : std::abs(axis.x) < 0.9 ? V3d(1, 0, 0) : V3d(0, 1, 0);
  c0 -= axis * (c0 ^ axis);
  if (!(axis.length() > 0) || !(c0.length() > 1e-9)) return fault("its axis and C0 are in one line");
  c0.normalize();
  const V3d c90 = c0 % axis;
  const double gamma_step = meter.gamma_step_degrees() > 0 ? meter.gamma_step_degrees() : 5,
               c_step = meter.c_step_degrees() > 0 ? meter.c_step_degrees() : 15;
  if (gamma_step < 0.05 || c_step < 0.05) return fault("its steps are below 0.05 degrees");
  for (double c = 0; c < 360 - 1e-9; c += c_step) {
    for (double gamma = 0; gamma <= 180 + 1e-9; gamma += gamma_step) {
      const double g = gamma * kPi / 180, angle = c * kPi / 180;
      ReceiverPlace place;
      place.normal = axis * std::cos(g) + (c0 * std::cos(angle) + c90 * std::sin(angle)) * std::sin(g);
      place.positions = {middle};
      *place.probe.mutable_disk()->mutable_middle() = point_of(middle);
      place.probe.mutable_disk()->set_radius(radius);
      *place.probe.mutable_axis() = point_of(place.normal);
      place.probe.set_offset(1.01 * radius);
      PlannedReading& reading = add_reading(absl::StrCat("C ", c, " gamma ", gamma));
      reading.position = middle, reading.normal = place.normal;
      reading.terms = {{add_probe(place, v1::Probe::FAR_FIELD), factor_ * square, channel_}};
    }
  }
  return absl::OkStatus();
}

void Planner::add_flux_of(const ReceiverPlace& place, v1::Probe::Kind kind, double sign,
                          PlannedReading& reading, ReadLight light) {
  const std::size_t first = add_probe(place, kind, light);
  for (std::size_t cell = 0; cell < place.positions.size(); ++cell)
    reading.terms.push_back({first + cell, sign * factor_ * place.area, channel_});
}

/// The outside of a ball around the scene, or its inside.
absl::StatusOr<ReceiverPlace> Planner::hull(bool inward) {
  auto ball = scene_.ball();
  if (!ball.ok()) return ball.status();
  ReceiverPlace place;
  // So far from lights at the edge of the scene that none outshines all others.
  const double radius = 1.5 * ball->radius;
  place.positions = {ball->middle};
  place.area = 4 * kPi * radius * radius;
  *place.probe.mutable_sphere()->mutable_middle() = point_of(ball->middle);
  place.probe.mutable_sphere()->set_radius(radius);
  place.probe.set_inward(inward);
  return place;
}

absl::Status Planner::add_flux(const v1::FluxMeter& meter) {
  factor_ *= square_metres();
  PlannedReading& reading = add_reading("");
  if (meter.escaping()) {
    const auto place = hull(true);
    if (!place.ok()) return place.status();
    add_flux_of(*place, v1::Probe::PLANE, 1, reading);
    return absl::OkStatus();
  }
  if (!meter.light().empty()) return fault("the flux of a light by its name is not measured yet");
  return for_each_place(meter.receivers(), [&](ReceiverPlace& place) {
    if (place.probe.has_point()) return fault("flux is of planes and surfaces");
    const bool sees_surface = meter.side() == v1::FluxMeter::ABSORBED ||
                              meter.side() == v1::FluxMeter::EMITTED ||
                              meter.side() == v1::FluxMeter::LEAVING;
    if (sees_surface && !(place.probe.offset() > 0)) return fault("an offset above 0 is needed here");
    if (meter.side() != v1::FluxMeter::BACK && !(meter.side() >= v1::FluxMeter::EMITTED))
      add_flux_of(place, v1::Probe::PLANE, 1, reading);
    if (meter.side() == v1::FluxMeter::NET) add_flux_of(other_side(place), v1::Probe::PLANE, -1, reading);
    if (meter.side() == v1::FluxMeter::BACK) add_flux_of(other_side(place), v1::Probe::PLANE, 1, reading);
    if (meter.side() == v1::FluxMeter::LEAVING) add_flux_of(place, v1::Probe::EXITANCE, 1, reading);
    if (meter.side() == v1::FluxMeter::EMITTED)
      add_flux_of(place, v1::Probe::EXITANCE, 1, reading, ReadLight::kStraight);
    if (meter.side() == v1::FluxMeter::ABSORBED) {
      add_flux_of(place, v1::Probe::EXITANCE, -1, reading);
      add_flux_of(place, v1::Probe::EXITANCE, 1, reading, ReadLight::kStraight);
    }
    return absl::OkStatus();
  });
}

absl::Status Planner::add_energy_balance() {
  factor_ *= square_metres();
  const v1::Scene& scene = scene_.imported.scene;
  PlannedMeter& meter = plan_.meters.back();
  if (scene.instances_size() > 0 || scene.has_packed_instances())
    return fault("the balance is of scenes whose shapes are placed one by one: this one has instances");
  if (scene.media_size() > 0) return fault("the balance is of scenes without media, which absorb light too");
  PlannedReading emitted = add_reading("emitted"), escaped = add_reading("escaped"),
                 residual = add_reading("residual");
  residual.is_judged = false;
  meter.readings.clear();
  const auto take = [&](const ReceiverPlace& place, v1::Probe::Kind kind, double sign, PlannedReading& to,
                        double in_residual, ReadLight light) {
    const std::size_t cell = add_probe(place, kind, light);
    to.terms.push_back({cell, sign * factor_ * place.area, channel_});
    residual.terms.push_back({cell, in_residual * sign * factor_ * place.area, channel_});
  };
  // Light that comes in from infinity, and that of lamps without a surface, is what crosses a ball around the
  // scene where it is scattered nowhere; what things in its way take is theirs.
  const auto outside = hull(false), inside = hull(true);
  if (!outside.ok()) return outside.status();
  take(*outside, v1::Probe::PLANE, 1, emitted, 1, ReadLight::kStraight);
  take(*inside, v1::Probe::PLANE, 1, escaped, -1, ReadLight::kAll);
  for (const v1::Light& light : scene.lights()) {
    if (light.has_infinite() || light.has_distant() || light.has_sky()) continue;
    if (!light.has_point() || light.point().intensity().kind_case() != v1::Spectrum::kRgb)
      return fault("of lights without a surface, the balance knows point lights with an intensity in RGB");
    const v1::Rgb& rgb = light.point().intensity().rgb();
    const double luminance = 0.2126 * rgb.r() + 0.7152 * rgb.g() + 0.0722 * rgb.b();
    const double flux =
        4 * kPi * luminance * (light.has_scale() ? light.scale() : 1) * factor_ / square_metres();
    emitted.constant += flux, residual.constant += flux;
  }
  std::vector<PlannedReading> absorbed;
  for (const v1::Shape& shape : scene.shapes()) {
    const std::string name =
        shape.name().empty() ? absl::StrCat("shape ", &shape - &scene.shapes(0) + 1) : shape.name();
    PlannedReading& taken = absorbed.emplace_back();
    taken.label = absl::StrCat("absorbed by ", name);
    taken.position = V3d(std::numeric_limits<double>::quiet_NaN());
    for (const bool back : {false, true}) {
      const auto place = surface_of(shape, scene_.imported, back);
      if (!place.ok()) return fault(absl::StrCat("shape '", name, "': ", place.status().message()));
      take(*place, v1::Probe::PLANE, 1, taken, -1, ReadLight::kAll);
      take(*place, v1::Probe::EXITANCE, -1, taken, -1, ReadLight::kAll);
      if (!shape.has_area_light()) continue;
      // Own light is emitted, and no part of what was not absorbed.
      const std::size_t own = add_probe(*place, v1::Probe::EXITANCE, ReadLight::kStraight);
      const double factor = factor_ * place->area;
      emitted.terms.push_back({own, factor, channel_});
      taken.terms.push_back({own, factor, channel_});
    }
  }
  meter.readings.push_back(std::move(emitted));
  for (PlannedReading& taken : absorbed) meter.readings.push_back(std::move(taken));
  meter.readings.push_back(std::move(escaped));
  meter.readings.push_back(std::move(residual));
  return absl::OkStatus();
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
    case v1::Meter::KIND_NOT_SET:
      break;
  }
  return fault("it says nothing of what it measures");
}

}  // namespace

absl::StatusOr<MeasuredScene> measured_scene(const ImportedScene& imported, const MeterFile& file,
                                             bool is_spectral, std::function<absl::StatusOr<Ball>()> ball) {
  MeasuredScene scene{.imported = imported};
  scene.is_spectral = is_spectral;
  scene.ball = std::move(ball);
  *scene.picture.mutable_camera() = imported.scene.camera();
  *scene.picture.mutable_film() = imported.scene.film();
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
  if (absl::Status s = file.status_of(faults); !s.ok()) return s;
  return planner.take();
}

}  // namespace tessera::client
