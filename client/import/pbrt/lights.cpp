#include "import/pbrt/lights.h"

#include <cmath>
#include <numbers>

#include "import/input/concat.h"
#include "import/pbrt/spectrum_values.h"

namespace tessera::client::pbrt {
namespace {

struct LightInput {
  Context& context;
  ParameterList& parameters;
  const Transform& world_from_light;
  double scale;  // of the result, so far

  Diagnostics& diagnostics() { return context.diagnostics; }
  double get_float(std::string_view name, double fallback) {
    return parameters.get_float(name, fallback, diagnostics());
  }
  void warn(std::string message) { diagnostics().warning(parameters.where(), std::move(message)); }

  v1::Spectrum spectrum(std::string_view name) {
    LightSpectrum light = read_light_spectrum(context, parameters, name);
    scale *= light.scale;
    return std::move(light.spectrum);
  }
};

void write_point(const Vector3& p, v1::Point3& point) {
  point.set_x(p[0]);
  point.set_y(p[1]);
  point.set_z(p[2]);
}

void write_point_light(LightInput& in, v1::Light& light) {
  *light.mutable_point()->mutable_intensity() = in.spectrum("I");
  const Vector3 from = in.parameters.get_point("from", {0, 0, 0}, in.diagnostics());
  write_point(in.world_from_light.apply_to_point(from), *light.mutable_point()->mutable_position());
  // `power` in lumens replaces the intensity: spread over the whole sphere.
  const double power = in.get_float("power", -1);
  if (power > 0) in.scale *= power / (4 * std::numbers::pi);
}

void write_patterned_light(LightInput& in, v1::Light& light) {
  in.warn(concat("the ", in.parameters.owner(), " is not supported yet: a point light without its pattern is used"));
  in.parameters.ignore({"filename", "fov"});
  write_point_light(in, light);
}

void write_spot(LightInput& in, v1::Light& light) {
  v1::SpotLight& spot = *light.mutable_spot();
  *spot.mutable_intensity() = in.spectrum("I");
  const Vector3 from = in.parameters.get_point("from", {0, 0, 0}, in.diagnostics());
  const Vector3 to = in.parameters.get_point("to", {0, 0, 1}, in.diagnostics());
  if (from == to) in.diagnostics().error(in.parameters.where(), "spot light: \"from\" and \"to\" are the same point");
  write_point(in.world_from_light.apply_to_point(from), *spot.mutable_position());
  write_point(in.world_from_light.apply_to_point(to), *spot.mutable_target());
  const double cone = in.get_float("coneangle", 30), delta = in.get_float("conedeltaangle", 5);
  spot.set_cone_angle_degrees(static_cast<float>(cone));
  spot.set_cone_delta_degrees(static_cast<float>(delta));
  const double power = in.get_float("power", -1);
  if (power > 0) {
    // Integral of the falloff over the sphere: whole inside, on average a half in the smoothstep's range.
    const double radians = std::numbers::pi / 180;
    const double cos_end = std::cos(cone * radians), cos_start = std::cos((cone - delta) * radians);
    in.scale *= power / (2 * std::numbers::pi * ((1 - cos_start) + (cos_start - cos_end) / 2));
  }
}

void write_distant(LightInput& in, v1::Light& light) {
  *light.mutable_distant()->mutable_irradiance() = in.spectrum("L");
  const Vector3 from = in.parameters.get_point("from", {0, 0, 0}, in.diagnostics());
  const Vector3 to = in.parameters.get_point("to", {0, 0, 1}, in.diagnostics());
  // pbrt: the light lies towards from - to, and so it travels along to - from.
  const Vector3 along = in.world_from_light.apply_to_vector({to[0] - from[0], to[1] - from[1], to[2] - from[2]});
  const double length = std::hypot(along[0], along[1], along[2]);
  if (!(length > 0)) {
    in.diagnostics().error(in.parameters.where(), "distant light: \"from\" and \"to\" are the same point");
    return;
  }
  write_point({along[0] / length, along[1] / length, along[2] / length}, *light.mutable_distant()->mutable_direction());
  const double illuminance = in.get_float("illuminance", -1);
  if (illuminance > 0) in.scale *= illuminance;
}

void write_infinite(LightInput& in, v1::Light& light) {
  v1::InfiniteLight& infinite = *light.mutable_infinite();
  if (in.parameters.has("portal")) {
    in.parameters.ignore({"portal"});
    in.warn("\"portal\" of an infinite light is not supported yet: the light comes from everywhere");
  }
  const double illuminance = in.get_float("illuminance", -1);
  const std::string file = in.parameters.get_string("filename", "", in.diagnostics());
  if (file.empty()) {
    *infinite.mutable_radiance() = in.spectrum("L");
    // A hemisphere of radiance 1 gives an irradiance of pi.
    if (illuminance > 0) in.scale *= illuminance / std::numbers::pi;
    return;
  }
  if (in.parameters.has("L")) {
    in.diagnostics().error(in.parameters.where(), "infinite light: expected either \"L\" or \"filename\"");
  }
  if (illuminance > 0) {
    in.warn("\"illuminance\" of an infinite light with an image is not supported yet: the image's own values are used");
  }
  absl::StatusOr<v1::BlobRef> image = in.context.blobs.add_file(in.context.resolve(file), file);
  if (!image.ok()) {
    in.diagnostics().error(in.parameters.where(), concat("image of the infinite light: ", image.status().message()));
    return;
  }
  *infinite.mutable_image() = *std::move(image);
  infinite.set_mapping(v1::InfiniteLight::EQUAL_AREA_OCTAHEDRAL);
  write_matrix(in.world_from_light, *infinite.mutable_world_from_light());
}

struct LightType {
  std::string_view name;
  void (*write)(LightInput& in, v1::Light& light);
};

constexpr LightType kTypes[] = {{"point", write_point_light},
                                {"spot", write_spot},
                                {"distant", write_distant},
                                {"infinite", write_infinite},
                                {"goniometric", write_patterned_light},
                                {"projection", write_patterned_light}};

}  // namespace

void add_light(Context& context, const std::string& type, ParameterList& parameters,
               const Transform& world_from_light) {
  for (const LightType& known : kTypes) {
    if (known.name != type) continue;
    LightInput in{context, parameters, world_from_light, parameters.get_float("scale", 1, context.diagnostics)};
    v1::Light light;
    known.write(in, light);
    if (in.scale != 1) light.set_scale(static_cast<float>(in.scale));
    light.set_name(concat(type, " light, line ", parameters.where().line));
    parameters.warn_of_unused(context.diagnostics);
    *context.scene.add_lights() = std::move(light);
    return;
  }
  context.diagnostics.error(
      parameters.where(),
      concat("unknown light type \"", type, "\": expected point, spot, distant, infinite, goniometric or projection"));
}

std::optional<AreaLightInput> read_area_light(Context& context, const std::string& type, ParameterList& parameters) {
  if (type != "diffuse") {
    context.diagnostics.error(parameters.where(), concat("unknown area light type \"", type, "\": expected diffuse"));
    return std::nullopt;
  }
  AreaLightInput result;
  result.where = parameters.where();
  LightSpectrum radiance = read_light_spectrum(context, parameters, "L");
  *result.light.mutable_radiance() = std::move(radiance.spectrum);
  const double scale = parameters.get_float("scale", 1, context.diagnostics) * radiance.scale;
  if (scale != 1) result.light.set_scale(static_cast<float>(scale));
  result.light.set_two_sided(parameters.get_bool("twosided", false, context.diagnostics));
  result.power = std::max(0.0, parameters.get_float("power", 0, context.diagnostics));
  if (parameters.has("filename")) {
    parameters.ignore({"filename"});
    context.diagnostics.warning(parameters.where(),
                                "an area light with an image is not supported yet: it emits evenly in white");
  }
  parameters.warn_of_unused(context.diagnostics);
  return result;
}

}  // namespace tessera::client::pbrt
