// Meters of light that leaves: intensity, flux, and the balance of all flux.
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "base/nearest_name.h"
#include "measure/planner.h"
#include "measure/surfaces.h"
#include "photometry/units/light_unit.h"

namespace tessera::client {

using Imath::V3d;

namespace {

constexpr double kPi = std::numbers::pi;

/// The flux of a light without a surface, of radiances with a luminance of 1 and over the square of the
/// scene's unit: by its amount, or of a point by its colour. Nothing where the message alone does not tell
/// it.
std::optional<double> told_flux(const v1::Light& light, const MeasuredScene& scene, double square_metres) {
  if (light.has_amount()) {
    const auto unit = photometry::parse_light_unit(light.amount().unit());
    if (!unit.ok()) return std::nullopt;
    const bool intensity = unit->quantity == photometry::Quantity::kIntensity && light.has_point();
    if (unit->quantity != photometry::Quantity::kFlux && !intensity) return std::nullopt;
    // Watts of wavelengths depend on the spectrum.
    if (!unit->photometric() && scene.is_spectral) return std::nullopt;
    const double lumens_per_unit = unit->factor * (unit->photometric() ? 1 : photometry::kLumensPerWatt);
    return light.amount().value() * lumens_per_unit * (intensity ? 4 * kPi : 1) /
           (scene.cd_per_m2 * square_metres);
  }
  if (!light.has_point() || light.point().intensity().kind_case() != v1::Spectrum::kRgb) return std::nullopt;
  const v1::Rgb& rgb = light.point().intensity().rgb();
  const double luminance = 0.2126 * rgb.r() + 0.7152 * rgb.g() + 0.0722 * rgb.b();
  return 4 * kPi * luminance * (light.has_scale() ? light.scale() : 1);
}

/// The scene without anything that shines or is lit.
v1::Scene without_light(const v1::Scene& scene) {
  v1::Scene rest = scene;
  rest.clear_lights(), rest.clear_shapes(), rest.clear_instances(), rest.clear_packed_instances();
  rest.clear_objects(), rest.clear_views();
  rest.mutable_settings()->clear_layers();
  return rest;
}

}  // namespace

double Planner::square_metres() {
  if (scene_.metres > 0) return scene_.metres * scene_.metres;
  plan_.meters.back().warnings.emplace_back(
      "neither the scene nor the meters say how long the scene's unit is: it is taken for a metre");
  return 1;
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
  // Lights at the edge of the scene are far enough from it that none outshines all others.
  const double radius = 1.5 * ball->radius;
  place.positions = {ball->middle};
  place.area = 4 * kPi * radius * radius;
  *place.probe.mutable_sphere()->mutable_middle() = point_of(ball->middle);
  place.probe.mutable_sphere()->set_radius(radius);
  place.probe.set_inward(inward);
  return place;
}

absl::StatusOr<double> Planner::flux_of_lamp(const v1::Light& light, double square_metres) const {
  if (const std::optional<double> told = told_flux(light, scene_, square_metres)) return *told;
  const std::string name = light.name().empty() ? "a light without a surface" : light.name();
  if (scene_.is_spectral)
    return fault(absl::StrCat(
        "'", name,
        "': with wavelengths the flux of a light is told where its amount is in lm, or its RGB of a point"));
  v1::Scene lights = without_light(scene_.imported.scene);
  *lights.add_lights() = light;
  auto flux = scene_.emitted_flux(lights);
  if (!flux.ok()) return fault(absl::StrCat("'", name, "': ", flux.status().message()));
  return flux;
}

absl::Status Planner::add_flux_of_light(const v1::FluxMeter& meter) {
  const std::string& name = meter.light();
  if (!meter.receivers().empty() || meter.escaping())
    return fault("it has a light, and receivers or what escapes: one of them was expected");
  if (meter.side() != v1::FluxMeter::EMITTED && meter.side() != v1::FluxMeter::NET)
    return fault("of a light by its name the flux that it emits is told: side is EMITTED");
  const v1::Scene& scene = scene_.imported.scene;
  const double square = square_metres();
  double sum = 0;
  std::vector<std::string> names;
  bool is_there = false;
  for (const v1::Light& light : scene.lights()) {
    for (const std::string& known : {light.name(), light.group()})
      if (!known.empty()) names.push_back(known);
    if (light.name() != name && light.group() != name) continue;
    if (light.has_infinite() || light.has_distant() || light.has_sky())
      return fault(absl::StrCat("light '", name, "' shines from infinity: its flux has no end"));
    const auto flux = flux_of_lamp(light, square);
    if (!flux.ok()) return flux.status();
    sum += *flux, is_there = true;
  }
  v1::Scene surfaces = without_light(scene);
  for (const v1::Shape& shape : scene.shapes()) {
    if (!shape.has_area_light()) continue;
    for (const std::string& known : {shape.name(), shape.area_light().group()})
      if (!known.empty()) names.push_back(known);
    if (shape.name() != name && shape.area_light().group() != name) continue;
    if (shape.motion_size() > 0 || shape.has_world_from_object_end() || shape.mesh().later_blobs_size() > 0)
      return fault(absl::StrCat("light '", name, "' is a surface that moves, whose size may change"));
    *surfaces.add_shapes() = shape;
  }
  for (const v1::Object& object : scene.objects()) {
    for (const v1::Shape& shape : object.shapes())
      if (shape.has_area_light() && (shape.name() == name || shape.area_light().group() == name))
        return fault(absl::StrCat("light '", name, "' is a surface of object '", object.name(),
                                  "', which instances may place anywhere and stretch"));
  }
  if (surfaces.shapes_size() > 0) {
    if (scene_.is_spectral)
      return fault(absl::StrCat("light '", name,
                                "': with wavelengths the flux of surfaces is not told by name; ",
                                "receivers with side EMITTED measure it"));
    const auto flux = scene_.emitted_flux(surfaces);
    if (!flux.ok()) return fault(absl::StrCat("light '", name, "': ", flux.status().message()));
    sum += *flux, is_there = true;
  }
  if (!is_there)
    return fault(absl::StrCat("there is no light or group '", name, "'", base::did_you_mean(name, names)));
  if (channel_ != ReadingChannel::kLuminance)
    return fault(absl::StrCat("light '", name, "': its flux is told in lm, and of RGB in W"));
  add_reading("").constant = sum * factor_ * square;
  return absl::OkStatus();
}

absl::Status Planner::add_flux(const v1::FluxMeter& meter) {
  if (!meter.light().empty()) return add_flux_of_light(meter);
  factor_ *= square_metres();
  PlannedReading& reading = add_reading("");
  if (meter.escaping()) {
    const auto place = hull(true);
    if (!place.ok()) return place.status();
    add_flux_of(*place, v1::Probe::PLANE, 1, reading);
    return absl::OkStatus();
  }
  return for_each_place(meter.receivers(), [&](ReceiverPlace& place) {
    if (place.probe.has_point()) return fault("flux is of planes and surfaces");
    if (place.mesh) return fault("flux is that of a whole surface: by_triangle is no part of it");
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
  const double square = square_metres();
  factor_ *= square;
  const v1::Scene& scene = scene_.imported.scene;
  PlannedMeter& meter = plan_.meters.back();
  if (scene.instances_size() > 0 || scene.has_packed_instances())
    return fault("the balance is of scenes whose shapes are placed one by one: this one has instances");
  if (scene.media_size() > 0) return fault("the balance is of scenes without media, which absorb light too");
  PlannedReading emitted = add_reading("emitted"), escaped = add_reading("escaped"),
                 residual = add_reading("residual");
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
    const auto lamp = flux_of_lamp(light, square);
    if (!lamp.ok()) return lamp.status();
    const double flux = *lamp * factor_;
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

}  // namespace tessera::client
