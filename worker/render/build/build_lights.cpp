#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "render/build/scene_builder.h"
#include "render/color/texture_load.h"
#include "render/light/environment.h"
#include "render/light/light_build.h"

namespace tessera::render {

namespace {

void put(Point p, float (&to)[3]) {
  to[0] = static_cast<float>(p.x), to[1] = static_cast<float>(p.y), to[2] = static_cast<float>(p.z);
}
void put(const Rgb& rgb, float scale, float (&to)[3]) { to[0] = rgb.r * scale, to[1] = rgb.g * scale, to[2] = rgb.b * scale; }

Point point_of(const v1::Point3& p) { return {p.x(), p.y(), p.z()}; }

absl::Status put_unit(Point direction, float (&to)[3]) {
  const double l = length(direction);
  if (!(l > 0) || !std::isfinite(l)) return absl::InvalidArgumentError("it has no direction");
  put({direction.x / l, direction.y / l, direction.z / l}, to);
  return absl::OkStatus();
}

}  // namespace

absl::Status SceneBuilder::build_lights() {
  tables_.lights.shapes = &tables_.shapes;
  int index = 0;
  for (const v1::Light& light : scene_.lights()) {
    const std::string where = light.name().empty() ? absl::StrCat("light ", index) : absl::StrCat("light ", index, " (", light.name(), ")");
    ++index;
    const float scale = light.has_scale() ? light.scale() : 1;
    if (!std::isfinite(scale)) return absl::InvalidArgumentError(absl::StrCat(where, ": its scale is not finite"));
    if (auto s = add_light(light, scale); !s.ok()) return located(s, where);
  }
  return absl::OkStatus();
}

absl::Status SceneBuilder::add_light(const v1::Light& light, float scale) {
  LightRecord record;
  const auto set_colour = [&](const v1::Spectrum& spectrum) {
    put(emission(spectrum), scale, record.radiance);
    return check_spectrum(spectrum, "colour");
  };
  absl::Status status;
  switch (light.kind_case()) {
    case v1::Light::kPoint:
      record.kind = LightKind::kPoint;
      put(point_of(light.point().position()) - camera_origin_, record.position);
      status = set_colour(light.point().intensity());
      break;
    case v1::Light::kSpot: {
      const v1::SpotLight& spot = light.spot();
      record.kind = LightKind::kSpot;
      put(point_of(spot.position()) - camera_origin_, record.position);
      status = set_colour(spot.intensity());
      if (status.ok()) status = put_unit(point_of(spot.target()) - point_of(spot.position()), record.direction);
      const double degree = 3.14159265358979323846 / 180;
      const double cone = std::clamp(double{spot.cone_angle_degrees()}, 0.0, 180.0);
      const double inner = std::clamp(cone - spot.cone_delta_degrees(), 0.0, cone);
      record.cos_outer = static_cast<float>(std::cos(cone * degree));
      record.cos_inner = static_cast<float>(std::cos(inner * degree));
      break;
    }
    case v1::Light::kDistant:
      record.kind = LightKind::kDistant;
      status = set_colour(light.distant().irradiance());
      if (status.ok()) status = put_unit(point_of(light.distant().direction()), record.direction);
      break;
    case v1::Light::kInfinite: return add_infinite_light(light.infinite(), scale);
    case v1::Light::KIND_NOT_SET: return absl::InvalidArgumentError("its kind is missing or unknown");
  }
  if (status.ok()) tables_.lights.lights.push_back(record);
  return status;
}

absl::Status SceneBuilder::add_infinite_light(const v1::InfiniteLight& light, float scale) {
  if (light.has_scale()) scale *= light.scale();
  auto world_from_light = Transform::from_proto(light.world_from_light());
  if (!world_from_light.ok()) return world_from_light.status();
  Transform light_from_world;
  if (!world_from_light->invert(light_from_world)) return absl::InvalidArgumentError("its transform is singular");

  Environment environment;
  if (light.has_image()) {
    auto bytes = blobs_(light.image().digest());
    if (!bytes.ok()) return located(bytes.status(), absl::StrCat("image '", light.image().path(), "'"));
    auto image = load_texture_image(bytes->bytes, light.image().path());
    if (!image.ok()) return image.status();
    auto built = build_environment(*image,
                                   light.mapping() == v1::InfiniteLight::LATITUDE_LONGITUDE
                                       ? EnvironmentMapping::kLatitudeLongitude
                                       : EnvironmentMapping::kEqualAreaOctahedral,
                                   scale, world_from_light->to_affine());
    if (!built.ok()) return located(built.status(), absl::StrCat("image '", light.image().path(), "'"));
    environment = *std::move(built);
  }

  LightRecord record;
  record.kind = LightKind::kInfinite;
  if (auto s = check_spectrum(light.radiance(), "radiance"); !s.ok()) return s;
  put(emission(light.radiance()), scale, record.radiance);
  record.environment = static_cast<std::int32_t>(tables_.lights.environments.size());
  tables_.lights.infinite_lights.push_back(static_cast<std::int32_t>(tables_.lights.lights.size()));
  tables_.lights.environments.push_back(std::move(environment));
  tables_.lights.lights.push_back(record);
  return absl::OkStatus();
}

absl::Status SceneBuilder::add_area_lights(const v1::AreaLight& light, std::int32_t shape) {
  if (auto s = check_spectrum(light.radiance(), "area light"); !s.ok()) return s;
  const float scale = light.has_scale() ? light.scale() : 1;
  if (!std::isfinite(scale)) return absl::InvalidArgumentError("area light: its scale is not finite");
  float radiance[3];
  put(emission(light.radiance()), scale, radiance);
  append_area_lights(tables_.shapes, shape, radiance, light.two_sided(), tables_.lights.lights);
  return absl::OkStatus();
}

absl::Status SceneBuilder::build_light_selection(float scene_radius) {
  tables_.lights.scene_radius = scene_radius;
  tables_.lights.selection = selection_by_power(tables_.lights);
  return absl::OkStatus();
}

}  // namespace tessera::render
