#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "render/build/scene_builder.h"
#include "render/color/texture_load.h"
#include "render/light/environment.h"
#include "render/light/light_build.h"
#include "render/light/light_source.h"
#include "render/light/selection/light_tree_build.h"

namespace tessera::render {

namespace {

void put(Point p, float (&to)[3]) {
  to[0] = static_cast<float>(p.x), to[1] = static_cast<float>(p.y), to[2] = static_cast<float>(p.z);
}
void put(const Rgb& rgb, float scale, float (&to)[3]) {
  to[0] = rgb.r * scale, to[1] = rgb.g * scale, to[2] = rgb.b * scale;
}

Point point_of(const v1::Point3& p) { return {p.x(), p.y(), p.z()}; }

absl::Status put_unit(Point direction, float (&to)[3]) {
  const double l = length(direction);
  if (!(l > 0) || !std::isfinite(l)) return absl::InvalidArgumentError("it has no direction");
  put({direction.x / l, direction.y / l, direction.z / l}, to);
  return absl::OkStatus();
}

constexpr double kDegree = 3.14159265358979323846 / 180;

Point unit(Point v) {
  const double l = length(v);
  return {v.x / l, v.y / l, v.z / l};
}

/// Rows of the rotation into a frame with its z axis along `axis` and its x axis along `side`.
absl::Status put_rotation(Point side, Point axis, float (&rows)[9]) {
  if (!(length(side) > 0) || !(length(axis) > 0))
    return absl::InvalidArgumentError("its orientation is not defined");
  const Point x = unit(side), z = unit(axis), y = cross(z, x);
  int i = 0;
  for (const Point row : {x, y, z}) {
    for (const double v : {row.x, row.y, row.z}) rows[i++] = static_cast<float>(v);
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status SceneBuilder::place_light(const v1::Matrix& matrix, LightRecord& record) {
  const auto world_from_light = Transform::from_proto(matrix);
  if (!world_from_light.ok()) return world_from_light.status();
  Transform light_from_world;
  if (!world_from_light->invert(light_from_world))
    return absl::InvalidArgumentError("its transform is singular");
  put(world_from_light->apply({0, 0, 0}) - render_origin_, record.position);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      record.vertices[3 * row + column] = static_cast<float>(light_from_world.m[4 * row + column]);
    }
  }
  return absl::OkStatus();
}

absl::Status SceneBuilder::set_light_texture(const std::string& name, LightRecord& record) {
  if (name.empty()) return absl::OkStatus();
  const auto node = texture_node(name);
  if (!node.ok()) return node.status();
  record.texture = *node;
  arrays_.lights.any_textures = true;
  return absl::OkStatus();
}

absl::Status SceneBuilder::set_portal(const v1::InfiniteLight& light, Environment& environment) {
  if (light.portal().empty()) return absl::OkStatus();
  if (algorithm_->starts_at_lights) {
    return absl::InvalidArgumentError(
        absl::StrCat("integrator '", algorithm_->name, "' cannot begin at a portal"));
  }
  if (light.portal_size() != 4) return absl::InvalidArgumentError("a portal has four corners");
  const Point p0 = point_of(light.portal(0));
  const Point u = point_of(light.portal(1)) - p0, v = point_of(light.portal(3)) - p0;
  const double area = length(cross(u, v));
  if (!(area > 0) || !std::isfinite(area)) return absl::InvalidArgumentError("its portal has no area");
  const Point corner = p0 - render_origin_;
  int i = 0;
  for (const Point row : {corner, u, v}) {
    for (const double x : {row.x, row.y, row.z}) environment.portal[i++] = static_cast<float>(x);
  }
  environment.portal_area = static_cast<float>(area);
  return absl::OkStatus();
}

absl::Status SceneBuilder::build_lights() {
  arrays_.lights.shapes = &arrays_.shapes;
  arrays_.lights.textures = &arrays_.textures;
  int index = 0;
  for (const v1::Light& light : scene_.lights()) {
    const std::string where = light.name().empty() ? absl::StrCat("light ", index)
                                                   : absl::StrCat("light ", index, " (", light.name(), ")");
    ++index;
    const float scale = light.has_scale() ? light.scale() : 1;
    if (!std::isfinite(scale))
      return absl::InvalidArgumentError(absl::StrCat(where, ": its scale is not finite"));
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
      put(point_of(light.point().position()) - render_origin_, record.position);
      status = set_colour(light.point().intensity());
      break;
    case v1::Light::kSpot: {
      const v1::SpotLight& spot = light.spot();
      record.kind = LightKind::kSpot;
      put(point_of(spot.position()) - render_origin_, record.position);
      status = set_colour(spot.intensity());
      const Point axis = point_of(spot.target()) - point_of(spot.position());
      if (status.ok()) status = put_unit(axis, record.direction);
      const double cone = std::clamp(double{spot.cone_angle_degrees()}, 0.0, 180.0);
      const double inner = std::clamp(cone - spot.cone_delta_degrees(), 0.0, cone);
      record.cos_outer = static_cast<float>(std::cos(cone * kDegree));
      record.cos_inner = static_cast<float>(std::cos(inner * kDegree));
      record.profile = spot.falloff() == v1::SpotLight::LINEAR ? kLinearAngle : kPlainProfile;
      if (status.ok() && !spot.texture().empty()) {
        if (cone >= 90)
          return absl::InvalidArgumentError(
              "a spot light with a texture needs a cone angle below 90 degrees");
        record.tan_x = record.tan_y = static_cast<float>(std::tan(cone * kDegree));
        status = put_rotation(cross(point_of(spot.up()), axis), axis, record.vertices);
        if (status.ok()) status = set_light_texture(spot.texture(), record);
      }
      break;
    }
    case v1::Light::kDistant:
      record.kind = LightKind::kDistant;
      status = set_colour(light.distant().irradiance());
      if (status.ok()) status = put_unit(point_of(light.distant().direction()), record.direction);
      break;
    case v1::Light::kProjection: {
      const v1::ProjectionLight& projection = light.projection();
      record.kind = LightKind::kProjection;
      record.profile = projection.even_screen() ? kEvenScreen : kPlainProfile;
      const double aspect = projection.has_aspect() ? projection.aspect() : 1, fov = projection.fov_degrees();
      if (!(fov > 0 && fov < 180) || !(aspect > 0 && std::isfinite(aspect))) {
        return absl::InvalidArgumentError(
            "its field of view is not in (0, 180) degrees, or its aspect not above 0");
      }
      const double tangent = std::tan(fov * kDegree / 2);
      record.tan_x = static_cast<float>(tangent * std::max(aspect, 1.0));
      record.tan_y = static_cast<float>(tangent * std::max(1 / aspect, 1.0));
      status = set_colour(projection.intensity());
      if (status.ok()) status = place_light(projection.world_from_light(), record);
      if (status.ok()) status = set_light_texture(projection.texture(), record);
      break;
    }
    case v1::Light::kGoniometric:
      record.kind = LightKind::kGoniometric;
      status = set_colour(light.goniometric().intensity());
      if (status.ok()) status = place_light(light.goniometric().world_from_light(), record);
      if (status.ok()) status = set_light_texture(light.goniometric().texture(), record);
      break;
    case v1::Light::kInfinite:
      return add_infinite_light(light.infinite(), scale);
    case v1::Light::KIND_NOT_SET:
      return absl::InvalidArgumentError("its kind is missing or unknown");
  }
  if (status.ok()) arrays_.lights.lights.push_back(record);
  return status;
}

absl::Status SceneBuilder::add_infinite_light(const v1::InfiniteLight& light, float scale) {
  if (light.has_scale()) scale *= light.scale();
  auto world_from_light = Transform::from_proto(light.world_from_light());
  if (!world_from_light.ok()) return world_from_light.status();
  Transform light_from_world;
  if (!world_from_light->invert(light_from_world))
    return absl::InvalidArgumentError("its transform is singular");

  // Paths from lights and portals have no other way to what is not sampled.
  const bool compensate = !algorithm_->samples_all_light && light.portal().empty();
  Environment environment;
  environment.sampled_share = compensate ? 0.0f : 1.0f;
  if (light.has_image()) {
    auto bytes = blobs_(light.image().digest());
    if (!bytes.ok()) return located(bytes.status(), absl::StrCat("image '", light.image().path(), "'"));
    auto image = load_texture_image(bytes->bytes, light.image().path());
    if (!image.ok()) return image.status();
    auto built = build_environment(*image,
                                   light.mapping() == v1::InfiniteLight::LATITUDE_LONGITUDE
                                       ? EnvironmentMapping::kLatitudeLongitude
                                       : EnvironmentMapping::kEqualAreaOctahedral,
                                   scale, world_from_light->to_affine(), compensate);
    if (!built.ok()) return located(built.status(), absl::StrCat("image '", light.image().path(), "'"));
    environment = *std::move(built);
  }

  if (auto s = set_portal(light, environment); !s.ok()) return s;
  LightRecord record;
  record.kind = LightKind::kInfinite;
  if (auto s = check_spectrum(light.radiance(), "radiance"); !s.ok()) return s;
  put(emission(light.radiance()), scale, record.radiance);
  record.environment = static_cast<std::int32_t>(arrays_.lights.environments.size());
  arrays_.lights.infinite_lights.push_back(static_cast<std::int32_t>(arrays_.lights.lights.size()));
  arrays_.lights.environments.push_back(std::move(environment));
  arrays_.lights.lights.push_back(record);
  return absl::OkStatus();
}

absl::Status SceneBuilder::add_area_lights(const v1::AreaLight& light, std::int32_t shape) {
  if (auto s = check_spectrum(light.radiance(), "area light"); !s.ok()) return s;
  const float scale = light.has_scale() ? light.scale() : 1;
  if (!std::isfinite(scale)) return absl::InvalidArgumentError("area light: its scale is not finite");
  float radiance[3];
  put(emission(light.radiance()), scale, radiance);
  LightRecord textured;
  if (auto s = set_light_texture(light.texture(), textured); !s.ok()) return located(s, "area light");
  std::vector<LightRecord>& lights = arrays_.lights.lights;
  const std::size_t first = lights.size();
  const float pick = light.interpolated_normal_pick();
  if (!(pick >= 0 && pick <= 1))
    return absl::InvalidArgumentError("area light: a probability is not within 0 and 1");
  append_area_lights(arrays_.shapes, shape, radiance, light.two_sided(), textured.texture, lights, pick);
  for (std::size_t i = first; i < lights.size(); ++i) {
    arrays_.lights.any_interpolated = arrays_.lights.any_interpolated || lights[i].profile == kInterpolated;
  }
  return absl::OkStatus();
}

absl::Status SceneBuilder::build_light_selection(float scene_radius) {
  LightTable& lights = arrays_.lights;
  lights.scene_radius = scene_radius;
  lights.selection = selection_of_lights(lights, light_selection_);
  const bool many = count_bounded_lights(lights) >= kFewestLightsOfATree;
  if (light_selection_ == LightSelection::kTree || (light_selection_ == LightSelection::kAuto && many)) {
    lights.tree = build_light_tree(lights);
  }
  lights.uses_normals =
      !lights.tree.empty() ||
      std::any_of(lights.lights.begin(), lights.lights.end(),
                  [&](const LightRecord& light) { return lights.sources(light.kind).traits.uses_normals; });
  return absl::OkStatus();
}

}  // namespace tessera::render
