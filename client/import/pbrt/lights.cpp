#include "import/pbrt/lights.h"

#include <cmath>
#include <numbers>

#include "import/input/concat.h"
#include "import/input/light_image.h"
#include "import/lamp/lamp_file.h"
#include "import/pbrt/matter/spectrum_values.h"

namespace tessera::client::pbrt {
namespace {

struct LightInput {
  Context& context;
  SceneTextures& textures;
  ParameterList& parameters;
  const Imath::M44d& world_from_light;
  const Imath::M44d* world_from_light_end;  // when the shutter closes; null: it does not move
  double scale;                             // scale of the result, so far

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

void write_point(const Imath::V3d& p, v1::Point3& point) {
  point.set_x(p[0]);
  point.set_y(p[1]);
  point.set_z(p[2]);
}

void write_point_light(LightInput& in, v1::Light& light) {
  *light.mutable_point()->mutable_intensity() = in.spectrum("I");
  const Imath::V3d from = in.parameters.get_point("from", {0, 0, 0}, in.diagnostics());
  write_point(from * in.world_from_light, *light.mutable_point()->mutable_position());
  if (in.world_from_light_end != nullptr)
    write_point(from * *in.world_from_light_end, *light.mutable_point()->mutable_position_end());
  // `power` in lumens replaces the intensity: spread over the whole sphere.
  const double power = in.get_float("power", -1);
  if (power > 0) in.scale *= power / (4 * std::numbers::pi);
}

/// Decodes the image; nothing after an error.
std::optional<LightImage> decode(Context& context, ParameterList& parameters, const std::string& file) {
  absl::StatusOr<LightImage> image = read_light_image(context.resolve(file));
  if (image.ok()) return *std::move(image);
  context.diagnostics.error(parameters.where(),
                            concat("image of the ", parameters.owner(), ": ", image.status().message()));
  return std::nullopt;
}

/// The texture of an image on a light; `filter` is pbrt-v4's for its kind. Its name, or "" after an error.
std::string light_texture(Context& context, SceneTextures& textures, ParameterList& parameters,
                          const std::string& file, v1::ImageTexture::Filter filter) {
  absl::StatusOr<v1::BlobRef> blob = context.blobs.add_file(context.resolve(file), file);
  if (!blob.ok()) {
    context.diagnostics.error(parameters.where(),
                              concat("image of the ", parameters.owner(), ": ", blob.status().message()));
    return "";
  }
  v1::Texture texture;
  v1::ImageTexture& image = *texture.mutable_image();
  *image.mutable_image() = *std::move(blob);
  image.set_wrap(v1::ImageTexture::CLAMP);
  image.set_filter(filter);
  return textures.add(file, std::move(texture));
}

/// Mean over the image of its luminance, weighted by the solid angle of its pixels [pbrt-v4 ProjectionLight].
double projected_mean(const LightImage& image, double half_width, double half_height) {
  double sum = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const double u = (2 * (x + 0.5) / image.width - 1) * half_width;
      const double v = (2 * (y + 0.5) / image.height - 1) * half_height;
      sum += image.luminance(x, y) / std::pow(1 + u * u + v * v, 1.5);
    }
  }
  return sum / (static_cast<double>(image.width) * image.height);
}

void write_projection(LightInput& in, v1::Light& light) {
  v1::ProjectionLight& projection = *light.mutable_projection();
  const std::string file = in.parameters.get_string("filename", "", in.diagnostics());
  if (file.empty()) {
    in.diagnostics().error(in.parameters.where(), "projection light: expected \"string filename\"");
    return;
  }
  const double fov = in.get_float("fov", 90), power = in.get_float("power", -1);
  if (!(fov > 0) || fov >= 180) {
    in.diagnostics().error(in.parameters.where(),
                           concat("projection light: fov ", fov, " is not in (0, 180)"));
    return;
  }
  const std::optional<LightImage> image = decode(in.context, in.parameters, file);
  if (!image) return;
  const double aspect = static_cast<double>(image->width) / image->height;
  const double shorter = std::tan(fov * std::numbers::pi / 360);
  const double half_width = shorter * std::max(aspect, 1.0),
               half_height = shorter * std::max(1 / aspect, 1.0);
  *projection.mutable_intensity() = rgb_spectrum({1, 1, 1});
  projection.set_fov_degrees(static_cast<float>(fov));
  if (aspect != 1) projection.set_aspect(static_cast<float>(aspect));
  projection.set_texture(
      light_texture(in.context, in.textures, in.parameters, file, v1::ImageTexture::NEAREST));
  // pbrt's image has its left upper corner at smallest x and largest y, ours at the opposite.
  const Imath::M44d turned = scaling(-1, -1, 1);
  write_matrix(turned * in.world_from_light, *projection.mutable_world_from_light());
  if (in.world_from_light_end != nullptr)
    write_all_elements(turned * *in.world_from_light_end, *projection.mutable_world_from_light_end());
  if (power > 0)
    in.scale *= power / (4 * half_width * half_height * projected_mean(*image, half_width, half_height));
}

/// A goniometric light of a photometric file, as bright as that says; with a power, as bright as other lights
/// of that power.
void write_lamp_file(LightInput& in, const std::string& file, double power, v1::Light& light) {
  std::vector<std::string> warnings;
  absl::StatusOr<v1::BlobRef> blob =
      add_lamp_file(in.context.resolve(file), file, in.context.blobs, warnings);
  for (const std::string& warning : warnings) in.warn(warning);
  if (!blob.ok()) {
    in.diagnostics().error(in.parameters.where(), std::string(blob.status().message()));
    return;
  }
  *light.mutable_goniometric()->mutable_photometric_file() = *std::move(blob);
  if (!(power > 0)) return;
  // Powers of pbrt's lights are of radiances with a luminance of 1, which stands for 683 cd/m2 here.
  constexpr double kLumens = 683;
  light.mutable_amount()->set_value(kLumens * power);
  light.mutable_amount()->set_unit("lm");
}

void write_goniometric(LightInput& in, v1::Light& light) {
  v1::GoniometricLight& goniometric = *light.mutable_goniometric();
  const double own_scale = in.scale;
  *goniometric.mutable_intensity() = in.spectrum("I");
  const double power = in.get_float("power", -1);
  double mean = 1;
  const std::string file = in.parameters.get_string("filename", "", in.diagnostics());
  // pbrt's own maps have y and z the other way round; a lamp hangs under +y.
  const Imath::M44d swap_yz(1, 0, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 1);
  write_matrix(swap_yz * in.world_from_light, *goniometric.mutable_world_from_light());
  if (in.world_from_light_end != nullptr)
    write_all_elements(swap_yz * *in.world_from_light_end, *goniometric.mutable_world_from_light_end());
  if (is_lamp_file(file)) {
    in.scale = own_scale;  // the spectrum's luminance does not count
    return write_lamp_file(in, file, power, light);
  }
  if (file.empty()) {
    in.warn("goniometric light: without \"string filename\" it shines evenly");
  } else if (const std::optional<LightImage> image = decode(in.context, in.parameters, file)) {
    if (image->width != image->height) {
      in.diagnostics().error(in.parameters.where(),
                             concat("image of the goniometric light: ", image->width, " x ", image->height,
                                    " pixels are not square, as an equal-area map is"));
    }
    double sum = 0;
    for (int y = 0; y < image->height; ++y) {
      for (int x = 0; x < image->width; ++x) sum += image->mean_of_channels(x, y);
    }
    mean = sum / (static_cast<double>(image->width) * image->height);
    goniometric.set_texture(
        light_texture(in.context, in.textures, in.parameters, file, v1::ImageTexture::NEAREST));
  }
  if (power > 0) in.scale *= power / (4 * std::numbers::pi * mean);
}

void write_spot(LightInput& in, v1::Light& light) {
  v1::SpotLight& spot = *light.mutable_spot();
  *spot.mutable_intensity() = in.spectrum("I");
  const Imath::V3d from = in.parameters.get_point("from", {0, 0, 0}, in.diagnostics());
  const Imath::V3d to = in.parameters.get_point("to", {0, 0, 1}, in.diagnostics());
  if (from == to)
    in.diagnostics().error(in.parameters.where(), "spot light: \"from\" and \"to\" are the same point");
  write_point(from * in.world_from_light, *spot.mutable_position());
  write_point(to * in.world_from_light, *spot.mutable_target());
  if (in.world_from_light_end != nullptr) {
    write_point(from * *in.world_from_light_end, *spot.mutable_position_end());
    write_point(to * *in.world_from_light_end, *spot.mutable_target_end());
  }
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
  const Imath::V3d from = in.parameters.get_point("from", {0, 0, 0}, in.diagnostics());
  const Imath::V3d to = in.parameters.get_point("to", {0, 0, 1}, in.diagnostics());
  // pbrt: the light lies towards from - to, and so it travels along to - from.
  const auto write_along = [&](const Imath::M44d& world_from_light, v1::Point3& direction) {
    const Imath::V3d along = transformed_vector(to - from, world_from_light);
    const double length = std::hypot(along[0], along[1], along[2]);
    if (!(length > 0)) {
      in.diagnostics().error(in.parameters.where(), "distant light: \"from\" and \"to\" are the same point");
      return false;
    }
    write_point({along[0] / length, along[1] / length, along[2] / length}, direction);
    return true;
  };
  if (!write_along(in.world_from_light, *light.mutable_distant()->mutable_direction())) return;
  if (in.world_from_light_end != nullptr &&
      !write_along(*in.world_from_light_end, *light.mutable_distant()->mutable_direction_end()))
    return;
  const double illuminance = in.get_float("illuminance", -1);
  if (illuminance > 0) in.scale *= illuminance;
}

/// Illuminance of an upward patch under an equal-area map, as pbrt-v4 reckons it: with the weight of a
/// hemisphere spread over all pixels.
double illuminance_of_map(const LightImage& image) {
  double sum = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      // z of the direction on the octahedral map [Clarberg 2008].
      const double inside =
          1 - (std::abs(2 * (x + 0.5) / image.width - 1) + std::abs(2 * (y + 0.5) / image.height - 1));
      if (inside <= 0) continue;
      const double z = 1 - (1 - inside) * (1 - inside);
      sum += image.luminance(x, y) * z;
    }
  }
  return sum * 2 * std::numbers::pi / (static_cast<double>(image.width) * image.height);
}

void read_portal(LightInput& in, v1::InfiniteLight& infinite) {
  const Parameter* portal = in.parameters.find("portal", {ParameterType::kPoint3}, in.diagnostics());
  if (portal == nullptr) return;
  if (portal->numbers.size() != 12) {
    in.diagnostics().error(portal->where, concat("portal of an infinite light: expected 4 points, found ",
                                                 portal->numbers.size() / 3));
    return;
  }
  // In world space whatever the transformation.
  for (std::size_t i = 0; i < 12; i += 3) {
    write_point({portal->numbers[i], portal->numbers[i + 1], portal->numbers[i + 2]}, *infinite.add_portal());
  }
}

void write_infinite(LightInput& in, v1::Light& light) {
  v1::InfiniteLight& infinite = *light.mutable_infinite();
  read_portal(in, infinite);
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
  absl::StatusOr<v1::BlobRef> blob = in.context.blobs.add_file(in.context.resolve(file), file);
  if (!blob.ok()) {
    in.diagnostics().error(in.parameters.where(),
                           concat("image of the infinite light: ", blob.status().message()));
    return;
  }
  if (illuminance > 0) {
    if (const std::optional<LightImage> image = decode(in.context, in.parameters, file)) {
      in.scale *= illuminance / illuminance_of_map(*image);
    }
  }
  *infinite.mutable_image() = *std::move(blob);
  infinite.set_mapping(v1::InfiniteLight::EQUAL_AREA_OCTAHEDRAL);
  write_matrix(in.world_from_light, *infinite.mutable_world_from_light());
  if (in.world_from_light_end == nullptr) return;
  if (infinite.portal().empty()) {
    write_all_elements(*in.world_from_light_end, *infinite.mutable_world_from_light_end());
  } else {
    in.warn("infinite light: with a portal it does not move: it stands as it is at the start");
  }
}

struct LightType {
  std::string_view name;
  void (*write)(LightInput& in, v1::Light& light);
};

constexpr LightType kLightTypes[] = {{"point", write_point_light},       {"spot", write_spot},
                                     {"distant", write_distant},         {"infinite", write_infinite},
                                     {"goniometric", write_goniometric}, {"projection", write_projection}};

}  // namespace

void add_light(Context& context, SceneTextures& textures, const std::string& type, ParameterList& parameters,
               const MovingTransform& world_from_light) {
  for (const LightType& known : kLightTypes) {
    if (known.name != type) continue;
    LightInput in{context,
                  textures,
                  parameters,
                  world_from_light.start,
                  world_from_light.moves() ? &world_from_light.end : nullptr,
                  parameters.get_float("scale", 1, context.diagnostics)};
    if (world_from_light.moves() && (world_from_light.begins > 0 || world_from_light.ends < 1))
      in.warn(concat(parameters.owner(), ": it moves evenly over all of the exposure, not a part of it"));
    v1::Light light;
    known.write(in, light);
    if (!std::isfinite(in.scale)) {
      context.diagnostics.error(parameters.where(),
                                concat(parameters.owner(), ": a dark image cannot give that power"));
      in.scale = 1;
    }
    if (in.scale != 1) light.set_scale(static_cast<float>(in.scale));
    const std::filesystem::path file = context.diagnostics.file_name(parameters.where().file);
    light.set_name(concat(type, " light, ", file.filename().string(), ":", parameters.where().line));
    v1::Light& added = *context.scene.add_lights();
    added = std::move(light);
    context.note(added, parameters.where(), concat(type, " light: "));
    return;
  }
  context.diagnostics.error(parameters.where(),
                            concat("unknown light type \"", type,
                                   "\": expected point, spot, distant, infinite, goniometric or projection"));
}

std::optional<AreaLightInput> read_area_light(Context& context, SceneTextures& textures,
                                              const std::string& type, ParameterList& parameters) {
  if (type != "diffuse") {
    context.diagnostics.error(parameters.where(),
                              concat("unknown area light type \"", type, "\": expected diffuse"));
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
  if (const std::string file = parameters.get_string("filename", "", context.diagnostics); !file.empty()) {
    if (parameters.has("L")) {
      context.diagnostics.error(parameters.where(), "area light: expected either \"L\" or \"filename\"");
    }
    result.light.set_texture(light_texture(context, textures, parameters, file, v1::ImageTexture::BILINEAR));
    if (result.power > 0) {
      const std::optional<LightImage> image = decode(context, parameters, file);
      if (!image) return std::nullopt;
      double sum = 0;
      for (int y = 0; y < image->height; ++y) {
        for (int x = 0; x < image->width; ++x) sum += image->luminance(x, y);
      }
      result.mean_image = sum / (static_cast<double>(image->width) * image->height);
    }
  }
  return result;
}

}  // namespace tessera::client::pbrt
