#include "import/mitsuba/emitters.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include "import/input/concat.h"
#include "import/input/light_image.h"
#include "import/mitsuba/field_of_view.h"

namespace tessera::client::mitsuba {
namespace {

void write_point(const Imath::V3d& from, v1::Point3& to) {
  to.set_x(from[0]);
  to.set_y(from[1]);
  to.set_z(from[2]);
}

Imath::V3d origin_of(const Imath::M44d& t) { return {t[3][0], t[3][1], t[3][2]}; }

/// Turns and shifts a light that has points or a direction; whatever else its transforms do is left out.
void write_way(PropertyReader& reader, const std::vector<TimedPlacing>& way, v1::Light& light) {
  if (!write_light_motion(way, light))
    reader.error(concat("a ", reader.object().title(), " that moves has a transform that is singular"));
}

v1::Spectrum emission(PropertyReader& reader, std::string_view name) {
  return read_color(reader, name, 1, ColorUse::kEmission).to_spectrum();
}

void write_point_light(PropertyReader& reader, SceneTextures&, v1::Light& light) {
  if (reader.has("position") && reader.has("to_world")) {
    reader.error("emitter \"point\": \"position\" and \"to_world\" exclude each other");
  }
  const std::vector<TimedPlacing> way = reader.motion("to_world");
  const Imath::V3d position = reader.vector("position").value_or(origin_of(way.front().place));
  write_point(position, *light.mutable_point()->mutable_position());
  write_way(reader, way, light);
  *light.mutable_point()->mutable_intensity() = emission(reader, "intensity");
}

void write_spot(PropertyReader& reader, SceneTextures& textures, v1::Light& light) {
  v1::SpotLight& spot = *light.mutable_spot();
  const std::vector<TimedPlacing> way = reader.motion("to_world");
  const Imath::M44d& to_world = way.front().place;
  write_point(origin_of(to_world), *spot.mutable_position());
  write_point(origin_of(to_world) + transformed_vector({0, 0, 1}, to_world), *spot.mutable_target());
  write_way(reader, way, light);
  *spot.mutable_intensity() = emission(reader, "intensity");
  const double cutoff = reader.number("cutoff_angle", 20), beam = reader.number("beam_width", 0.75 * cutoff);
  if (!(cutoff > 0 && cutoff <= 180) || !(beam >= 0 && beam <= cutoff)) {
    reader.error(concat("emitter \"spot\": expected 0 <= beam_width <= cutoff_angle <= 180, found ", beam,
                        " and ", cutoff));
  }
  spot.set_cone_angle_degrees(static_cast<float>(cutoff));
  spot.set_cone_delta_degrees(static_cast<float>(cutoff - beam));
  spot.set_falloff(v1::SpotLight::LINEAR);
  Object* texture = reader.named_child("texture", "texture");
  if (texture == nullptr) return;
  spot.set_texture(textures.use(*texture, TextureRole::kColor));
  write_point(transformed_vector({0, 1, 0}, to_world), *spot.mutable_up());
  // u grows along cross(up, axis), in Mitsuba as here, as long as nothing mirrors.
  if (determinant3(to_world) < 0) {
    reader.warn("the transformation of a spot mirrors its texture in Mitsuba: it is not mirrored here");
  }
}

void write_directional(PropertyReader& reader, SceneTextures&, v1::Light& light) {
  if (reader.has("direction") && reader.has("to_world")) {
    reader.error("emitter \"directional\": \"direction\" and \"to_world\" exclude each other");
  }
  const std::vector<TimedPlacing> way = reader.motion("to_world");
  const Imath::V3d direction =
      reader.vector("direction").value_or(transformed_vector({0, 0, 1}, way.front().place));
  if (!(std::hypot(direction[0], direction[1], direction[2]) > 0)) {
    reader.error("emitter \"directional\": its direction is zero");
  }
  write_point(direction, *light.mutable_distant()->mutable_direction());
  write_way(reader, way, light);
  *light.mutable_distant()->mutable_irradiance() = emission(reader, "irradiance");
}

void write_constant(PropertyReader& reader, SceneTextures&, v1::Light& light) {
  *light.mutable_infinite()->mutable_radiance() = emission(reader, "radiance");
}

void write_environment(PropertyReader& reader, SceneTextures&, v1::Light& light) {
  v1::InfiniteLight& infinite = *light.mutable_infinite();
  infinite.set_mapping(v1::InfiniteLight::LATITUDE_LONGITUDE);
  const double scale = reader.number("scale", 1);
  if (scale != 1) infinite.set_scale(static_cast<float>(scale));
  const std::vector<TimedPlacing> way = reader.motion("to_world");
  write_matrix(way.front().place, *infinite.mutable_world_from_light());
  write_motion(way, light);
  reader.ignore({"mis_compensation"});
  const std::optional<std::filesystem::path> path = reader.file("filename");
  if (!path) return;
  absl::StatusOr<v1::BlobRef> blob = reader.context().blobs.add_file(*path, reader.text("filename", ""));
  if (blob.ok()) {
    *infinite.mutable_image() = *std::move(blob);
  } else {
    reader.error(*reader.find("filename"), std::string(blob.status().message()));
  }
}

/// Width over height of a texture: that of its image, 1 for others.
double aspect_of(Context& context, Object* texture) {
  if (texture == nullptr || texture->type != "bitmap") return 1;
  PropertyReader nested(context, *texture);
  const std::optional<std::filesystem::path> path = nested.file("filename");
  if (!path) return 1;
  const absl::StatusOr<images::ImageSize> size = read_image_size(*path);
  if (size.ok()) return static_cast<double>(size->width) / size->height;
  nested.error(std::string(size.status().message()));
  return 1;
}

void write_projector(PropertyReader& reader, SceneTextures& textures, v1::Light& light) {
  v1::ProjectionLight& projector = *light.mutable_projection();
  projector.set_even_screen(true);
  const std::vector<TimedPlacing> way = reader.motion("to_world");
  write_matrix(way.front().place, *projector.mutable_world_from_light());
  write_motion(way, light);
  // Mitsuba's "irradiance" is short of a factor pi.
  const double scale = reader.number("scale", 1) * std::numbers::pi;
  Object* varying = nullptr;
  ConstantColor color{{1, 1, 1}};
  if (const Property* irradiance = reader.find("irradiance")) {
    if (const auto constant = read_constant_color(reader, *irradiance, ColorUse::kEmission)) {
      color = *constant;
    } else {
      varying = reader.named_child("irradiance", "texture");
    }
  }
  color *= scale;
  *projector.mutable_intensity() = color.to_spectrum();
  if (varying != nullptr) projector.set_texture(textures.use(*varying, TextureRole::kColor));

  const double aspect = aspect_of(reader.context(), varying);
  const double half_width = read_half_width(reader, aspect);
  const double half_shorter_side = std::min(half_width, half_width / aspect);
  projector.set_fov_degrees(static_cast<float>(2 * std::atan(half_shorter_side) * 180 / std::numbers::pi));
  if (aspect != 1) projector.set_aspect(static_cast<float>(aspect));
}

/// The emitter's weight in Mitsuba's choice among emitters. It only changes what the image converges to where
/// vertex normals stand in for true ones (AreaLight.interpolated_normal_pick).
double read_sampling_weight(PropertyReader& reader) {
  const double weight = reader.number("sampling_weight", 1);
  if (!(weight >= 0))
    reader.error(*reader.find("sampling_weight"), concat("expected 0 or more, found ", weight));
  return weight;
}

struct LightType {
  std::string_view name;
  void (*write)(PropertyReader& reader, SceneTextures& textures, v1::Light& light);
};

constexpr LightType kLightTypes[] = {{"point", write_point_light},       {"spot", write_spot},
                                     {"directional", write_directional}, {"constant", write_constant},
                                     {"envmap", write_environment},      {"projector", write_projector}};

}  // namespace

void write_light(Context& context, SceneTextures& textures, Object& emitter) {
  PropertyReader reader(context, emitter);
  const auto type = std::find_if(std::begin(kLightTypes), std::end(kLightTypes),
                                 [&](const LightType& known) { return known.name == emitter.type; });
  if (type == std::end(kLightTypes)) {
    reader.error(emitter.type == "area"
                     ? std::string("an emitter \"area\" must stand inside a shape")
                     : concat("emitter \"", emitter.type,
                              "\" is not supported: expected point, spot, directional, constant, "
                              "envmap, area or projector"));
    return;
  }
  context.emitter_weight += read_sampling_weight(reader);
  if (reader.child("medium") != nullptr)
    reader.warn(concat("the medium around an ", emitter.title(), " is left out"));
  v1::Light light;
  light.set_name(context.name_with_place(emitter));
  light.set_group(emitter.id);
  type->write(reader, textures, light);
  v1::Light& added = *context.scene.add_lights();
  added = std::move(light);
  context.note(added, emitter);
}

void write_area_light(Context& context, SceneTextures& textures, Object& emitter, bool may_have_normals,
                      v1::Shape& shape) {
  PropertyReader reader(context, emitter);
  if (emitter.type != "area") {
    reader.error(concat("emitter \"", emitter.type, "\" is not supported on a shape: expected area"));
    return;
  }
  const double weight = read_sampling_weight(reader);
  context.emitter_weight += weight;
  v1::AreaLight& light = *shape.mutable_area_light();
  light.set_group(emitter.id);
  if (may_have_normals && weight > 0) light.set_interpolated_normal_pick(static_cast<float>(weight));
  const Property* radiance = reader.find("radiance");
  Object* const* object = radiance == nullptr ? nullptr : std::get_if<Object*>(&radiance->value);
  const auto constant = radiance == nullptr ? std::optional(ConstantColor{{1, 1, 1}})
                                            : read_constant_color(reader, *radiance, ColorUse::kEmission);
  *light.mutable_radiance() = constant.value_or(ConstantColor{{1, 1, 1}}).to_spectrum();
  if (!constant && object != nullptr && (*object)->tag == "texture") {
    light.set_texture(textures.use(**object, TextureRole::kColor));
  } else if (!constant) {
    reader.error(*radiance, "expected a colour or a texture");
  }
}

void finish_area_lights(Context& context) {
  for (v1::Shape& shape : *context.scene.mutable_shapes()) {
    if (!shape.area_light().has_interpolated_normal_pick()) continue;
    v1::AreaLight& light = *shape.mutable_area_light();
    light.set_interpolated_normal_pick(
        static_cast<float>(light.interpolated_normal_pick() / context.emitter_weight));
  }
}

}  // namespace tessera::client::mitsuba
