#include "render/scene/light/light_builder.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "render/light/light_source.h"
#include "render/light/selection/light_tree_build.h"
#include "render/scene/light/light_values.h"
#include "render/scene/light/moving_light.h"
#include "render/scene/values/located.h"

namespace tessera::render {

namespace {

void put_vector(Imath::V3d p, float (&to)[3]) {
  to[0] = static_cast<float>(p.x), to[1] = static_cast<float>(p.y), to[2] = static_cast<float>(p.z);
}

absl::Status put_unit(Imath::V3d direction, float (&to)[3]) {
  const double l = direction.length();
  if (!(l > 0) || !std::isfinite(l)) return absl::InvalidArgumentError("it has no direction");
  put_vector(direction / l, to);
  return absl::OkStatus();
}

constexpr double kDegree = 3.14159265358979323846 / 180;

Imath::V3d unit(const Imath::V3d& v) { return v / v.length(); }

/// Rows of the rotation into a frame with its z axis along `axis` and its x axis along `side`.
absl::Status put_rotation(Imath::V3d side, Imath::V3d axis, float (&rows)[9]) {
  if (!(side.length() > 0) || !(axis.length() > 0))
    return absl::InvalidArgumentError("its orientation is not defined");
  const Imath::V3d x = unit(side), z = unit(axis), y = z.cross(x);
  int i = 0;
  for (const Imath::V3d& row : {x, y, z}) {
    for (const double v : {row.x, row.y, row.z}) rows[i++] = static_cast<float>(v);
  }
  return absl::OkStatus();
}

absl::Status set_way(absl::StatusOr<LightWay> found, LightWay& way) {
  absl::Status status = found.status();
  if (status.ok()) way = *std::move(found);
  return status;
}

/// A light of the kind `soft` if it has a radius.
absl::Status set_radius(float radius, LightKind soft, LightRecord& record) {
  if (!(radius >= 0) || !std::isfinite(radius))
    return absl::InvalidArgumentError("its radius is negative or not finite");
  record.radius = radius;
  if (radius > 0) record.kind = soft;
  return absl::OkStatus();
}

}  // namespace

template <class Message>
absl::Status LightBuilder::place(const Message& light, const MotionKeys& keys, LightRecord& record,
                                 LightWay& way) const {
  const auto world_from_light = Transform::from_proto(light.world_from_light());
  if (!world_from_light.ok()) return world_from_light.status();
  Transform light_from_world;
  if (!world_from_light->invert(light_from_world))
    return absl::InvalidArgumentError("its transform is singular");
  auto motion = Motion::from_proto(light.world_from_light(), light.world_from_light_end(), keys);
  if (!motion.ok()) return motion.status();
  way.motion = *std::move(motion);
  // A light that moves has the axes of its own space.
  if (way.moves()) light_from_world = {};
  put_vector(world_from_light->apply({0, 0, 0}) - inputs_.space.origin, record.position);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      record.vertices[3 * row + column] = static_cast<float>(light_from_world.m[4 * row + column]);
    }
  }
  return absl::OkStatus();
}

absl::Status LightBuilder::set_color(const v1::Spectrum& spectrum, float scale, const char* what,
                                     LightRecord& record) {
  if (auto s = check_spectrum(spectrum, what); !s.ok()) return s;
  latest_ = inputs_.spectral == nullptr ? SpectralEmission{emission(spectrum)}
                                        : inputs_.spectral->emission_of(spectrum);
  put(latest_.color, scale, record.radiance);
  return absl::OkStatus();
}

void LightBuilder::note_curve() {
  curves_.resize(table_.lights.size(), latest_.curve);
  if (moving_ != nullptr) moving_->motion_of_light.resize(table_.lights.size(), -1);
}

void LightBuilder::warn_of_roughness(const std::string& place) {
  if (inputs_.warnings != nullptr && !roughness_.empty())
    inputs_.warnings->push_back(absl::StrCat(place, ": ", roughness_));
}

void LightBuilder::warn_of_color(const std::string& place) {
  if (inputs_.warnings != nullptr && latest_.unreached.is_told())
    inputs_.warnings->push_back(absl::StrCat(place, ": ", latest_.unreached.to_string()));
}

std::vector<std::int32_t> LightBuilder::curves_by_light() const {
  return std::ranges::all_of(curves_, [](std::int32_t curve) { return curve < 0; })
             ? std::vector<std::int32_t>()
             : curves_;
}

absl::Status LightBuilder::set_texture(const std::string& name, LightRecord& record) {
  if (name.empty()) return absl::OkStatus();
  const auto node = inputs_.textures.exact_node(name);
  if (!node.ok()) return node.status();
  record.texture = *node;
  table_.any_textures = true;
  return absl::OkStatus();
}

absl::Status LightBuilder::add_lights(const Lights& lights) {
  FaultList faults(1);
  add_lights(lights, faults);
  return faults.first();
}

void LightBuilder::add_lights(const Lights& lights, FaultList& faults) {
  for (int i = 0; i < lights.size() && !faults.full(); ++i) {
    place_ = place_in_scene("light", i, lights[i].name());
    if (!faults.add(lights[i], place_, add_light(lights[i]))) continue;
    warn_of_color(place_);
    warn_of_roughness(place_);
  }
}

absl::Status LightBuilder::add_light(const v1::Light& light) {
  const float scale = light.has_scale() ? light.scale() : 1;
  if (!std::isfinite(scale)) return absl::InvalidArgumentError("its scale is not finite");
  roughness_.clear();
  if (light.has_infinite()) return add_infinite(light, scale);
  if (light.has_sky()) return add_sky(light, scale);
  LightRecord record;
  LightWay way;
  const std::size_t first = table_.lights.size();
  const bool has_amount = light.has_amount() || light.goniometric().has_photometric_file();
  if (auto s = set_kind(light, has_amount ? 1 : scale, record, way); !s.ok()) return s;
  if (way.moves()) {
    if (auto s = add_moving_light(way, record); !s.ok()) return s;
  } else {
    table_.lights.push_back(record);
  }
  note_curve();
  return set_amount(light, record, first);
}

absl::Status LightBuilder::set_kind(const v1::Light& light, float scale, LightRecord& record, LightWay& way) {
  switch (light.kind_case()) {
    case v1::Light::kPoint:
      record.kind = LightKind::kPoint;
      put_vector(point_of(light.point().position()) - inputs_.space.origin, record.position);
      if (auto s = set_radius(light.point().radius(), LightKind::kSoftPoint, record); !s.ok()) return s;
      if (auto s = set_way(way_of_point(light.point(), light.motion()), way); !s.ok()) return s;
      return set_color(light.point().intensity(), scale, "colour", record);
    case v1::Light::kSpot:
      if (auto s = set_color(light.spot().intensity(), scale, "colour", record); !s.ok()) return s;
      if (auto s = set_spot(light.spot(), record); !s.ok()) return s;
      return set_way(way_of_spot(light.spot(), light.motion()), way);
    case v1::Light::kDistant:
      record.kind = LightKind::kDistant;
      if (auto s = set_color(light.distant().irradiance(), scale, "colour", record); !s.ok()) return s;
      if (auto s = put_unit(point_of(light.distant().direction()), record.direction); !s.ok()) return s;
      return set_way(way_of_distant(light.distant(), light.motion()), way);
    case v1::Light::kProjection:
      if (auto s = set_color(light.projection().intensity(), scale, "colour", record); !s.ok()) return s;
      if (auto s = place(light.projection(), light.motion(), record, way); !s.ok()) return s;
      return set_projection(light.projection(), record);
    case v1::Light::kGoniometric:
      return set_goniometric(light.goniometric(), light.motion(), scale, record, way);
    case v1::Light::kInfinite:
    case v1::Light::kSky:
    case v1::Light::KIND_NOT_SET:
      break;
  }
  return absl::InvalidArgumentError("its kind is missing or unknown");
}

absl::Status LightBuilder::set_goniometric(const v1::GoniometricLight& light, const MotionKeys& keys,
                                           float scale, LightRecord& record, LightWay& way) {
  record.kind = LightKind::kGoniometric;
  v1::Spectrum color = light.intensity();
  // Lamps of files are white where nothing is said.
  if (light.has_photometric_file() && color.kind_case() == v1::Spectrum::KIND_NOT_SET && !color.has_in_rgb())
    color.set_constant(1);
  if (auto s = set_color(color, scale, "colour", record); !s.ok()) return s;
  if (auto s = place(light, keys, record, way); !s.ok()) return s;
  return light.has_photometric_file() ? set_photometric_file(light, record)
                                      : set_texture(light.texture(), record);
}

absl::Status LightBuilder::set_spot(const v1::SpotLight& spot, LightRecord& record) {
  record.kind = LightKind::kSpot;
  if (auto s = set_radius(spot.radius(), LightKind::kSoftSpot, record); !s.ok()) return s;
  put_vector(point_of(spot.position()) - inputs_.space.origin, record.position);
  const Imath::V3d axis = point_of(spot.target()) - point_of(spot.position());
  if (auto s = put_unit(axis, record.direction); !s.ok()) return s;
  const double cone = std::clamp(double{spot.cone_angle_degrees()}, 0.0, 180.0);
  const double inner = std::clamp(cone - spot.cone_delta_degrees(), 0.0, cone);
  record.cos_outer = static_cast<float>(std::cos(cone * kDegree));
  record.cos_inner = static_cast<float>(std::cos(inner * kDegree));
  record.profile = spot.falloff() == v1::SpotLight::LINEAR ? kLinearAngle : kPlainProfile;
  if (spot.texture().empty()) return absl::OkStatus();
  if (cone >= 90) {
    return absl::InvalidArgumentError("a spot light with a texture needs a cone angle below 90 degrees");
  }
  record.tan_x = record.tan_y = static_cast<float>(std::tan(cone * kDegree));
  if (auto s = put_rotation(point_of(spot.up()).cross(axis), axis, record.vertices); !s.ok()) return s;
  return set_texture(spot.texture(), record);
}

absl::Status LightBuilder::set_projection(const v1::ProjectionLight& projection, LightRecord& record) {
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
  return set_texture(projection.texture(), record);
}

absl::Status LightBuilder::add_area_lights(const std::vector<Emitter>& emitters, ShapeTable& shapes) {
  if (emitters.empty()) return absl::OkStatus();
  const std::vector<std::int32_t> instances = instances_by_shape(shapes);
  for (const Emitter& emitter : emitters) {
    const std::int32_t instance = instances[static_cast<std::size_t>(emitter.shape)];
    place_ = absl::StrCat(emitter.where, ": area light");
    if (auto s = add_area_light(emitter, instance, shapes); !s.ok()) return located(s, place_);
    warn_of_color(place_);
  }
  return absl::OkStatus();
}

absl::StatusOr<LightRecord> LightBuilder::read_area_light(const v1::AreaLight& light) {
  const float scale = light.has_scale() ? light.scale() : 1;
  if (!std::isfinite(scale)) return absl::InvalidArgumentError("its scale is not finite");
  LightRecord record;
  if (auto s = set_color(light.radiance(), light.has_amount() ? 1 : scale, "radiance", record); !s.ok())
    return s;
  if (light.has_amount()) {
    if (auto s = read_amount(light.amount(), light).status(); !s.ok()) return s;
  }
  if (auto s = set_texture(light.texture(), record); !s.ok()) return s;
  const float pick = light.interpolated_normal_pick();
  if (!(pick >= 0 && pick <= 1)) return absl::InvalidArgumentError("a probability is not within 0 and 1");
  return record;
}

absl::Status LightBuilder::check_area_light(const v1::AreaLight& light) {
  return located(read_area_light(light).status(), "area light");
}

absl::Status LightBuilder::add_area_light(const Emitter& emitter, std::int32_t instance, ShapeTable& shapes) {
  const v1::AreaLight& light = *emitter.light;
  const auto record = read_area_light(light);
  if (!record.ok()) return record.status();
  const std::size_t first = table_.lights.size();
  if (instance >= 0) {
    const InstanceRecord& place = shapes.instances[static_cast<std::size_t>(instance)];
    add_moving_area_light(emitter, *record, place, shapes);
  } else {
    append_area_lights(shapes, emitter.shape, record->radiance, light.two_sided(), record->texture, table_,
                       light.interpolated_normal_pick());
  }
  note_curve();
  return set_amount(light, instance >= 0, first);
}

namespace {

LightSelection selection_of(const v1::Algorithms& asked) {
  if (asked.direct_light() == v1::DIRECT_LIGHT_BSDF) return LightSelection::kNone;
  switch (asked.light_selection()) {
    case v1::LIGHT_SELECTION_TREE:
      return LightSelection::kTree;
    case v1::LIGHT_SELECTION_MIXED:
      return LightSelection::kMixed;
    case v1::LIGHT_SELECTION_POWER:
      return LightSelection::kPower;
    case v1::LIGHT_SELECTION_UNIFORM:
      return LightSelection::kUniform;
    default:
      return LightSelection::kAuto;
  }
}

}  // namespace

void build_light_selection(const v1::Algorithms& asked, const float* centre, float radius,
                           LightTable& table) {
  const LightSelection kind = selection_of(asked);
  std::copy_n(centre, 3, table.scene_centre);
  table.scene_radius = radius;
  table.selection = selection_of_lights(table, kind);
  const bool many = count_bounded_lights(table) >= kFewestLightsOfATree;
  if (kind == LightSelection::kTree || (kind == LightSelection::kAuto && many)) {
    table.tree = build_light_tree(table);
  }
  table.uses_normals = !table.tree.empty() ||
                       std::any_of(table.lights.begin(), table.lights.end(), [&](const LightRecord& light) {
                         return table.sources(light.kind).traits.uses_normals;
                       });
}

}  // namespace tessera::render
