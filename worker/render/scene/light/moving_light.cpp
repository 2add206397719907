// Lights that move: the way of each from its own space to render space, and its records there and here.
#include "render/scene/light/moving_light.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "render/light/moving_lights.h"
#include "render/scene/light/light_builder.h"
#include "render/scene/light/light_values.h"

namespace tessera::render {

namespace {

/// Columns are the axes of a frame, and its origin.
Transform frame_of(const Imath::V3d& x, const Imath::V3d& y, const Imath::V3d& z, const Imath::V3d& origin) {
  return {{x.x, y.x, z.x, origin.x, x.y, y.y, z.y, origin.y, x.z, y.z, z.z, origin.z}};
}

/// The shortest turn that takes one direction to another.
absl::StatusOr<Transform> turn_between(const Imath::V3d& from, const Imath::V3d& to) {
  if (!(from.length() > 0) || !(to.length() > 0) || !std::isfinite(from.length() + to.length()))
    return absl::InvalidArgumentError("it has no direction");
  const Imath::V3d a = from.normalized(), b = to.normalized();
  Imath::V3d axis = a.cross(b);
  if (axis.length() < 1e-9) {
    if (a.dot(b) > 0) return Transform{};
    // Half a turn, about any axis across it.
    axis = a.cross(std::abs(a.x) < 0.5 ? Imath::V3d(1, 0, 0) : Imath::V3d(0, 1, 0));
  }
  const Imath::V3d n = axis.normalized(), start = n.cross(a), end = n.cross(b);
  return frame_of(b, n, end, {0, 0, 0}) *
         Transform{{a.x, a.y, a.z, 0, n.x, n.y, n.z, 0, start.x, start.y, start.z, 0}};
}

/// The turn that takes one frame of axis and upward direction to another.
absl::StatusOr<Transform> turn_between(const Imath::V3d& axis, const Imath::V3d& up,
                                       const Imath::V3d& new_axis, const Imath::V3d& new_up) {
  const Imath::V3d side = up.cross(axis), new_side = new_up.cross(new_axis);
  for (const Imath::V3d& v : {axis, side, new_axis, new_side})
    if (!(v.length() > 0)) return absl::InvalidArgumentError("its orientation is not defined");
  const Imath::V3d z = axis.normalized(), x = side.normalized(), y = z.cross(x);
  const Imath::V3d new_z = new_axis.normalized(), new_x = new_side.normalized();
  return frame_of(new_x, new_z.cross(new_x), new_z, {0, 0, 0}) *
         Transform{{x.x, x.y, x.z, 0, y.x, y.y, y.z, 0, z.x, z.y, z.z, 0}};
}

bool is_at_infinity(LightKind kind) { return kind == LightKind::kDistant || is_environment(kind); }

/// The kind that a light of a still kind has while it moves. Models are not asked: there are none where
/// scenes are only checked.
LightKind moving_kind(const LightRecord& still) {
  if (still.shape >= 0) return LightKind::kMovingSurface;
  if (still.kind == LightKind::kDistant) return LightKind::kMovingDistant;
  if (is_environment(still.kind)) return LightKind::kMovingInfinite;
  return still.radius > 0 ? LightKind::kMovingSoft : LightKind::kMovingPoint;
}

}  // namespace

absl::StatusOr<Motion> motion_of_point(const v1::PointLight& light) {
  if (!light.has_position_end()) return Motion(Transform{});
  return Motion::between(Transform::translation(point_of(light.position())),
                         Transform::translation(point_of(light.position_end())));
}

absl::StatusOr<Motion> motion_of_spot(const v1::SpotLight& light) {
  if (!light.has_position_end() && !light.has_target_end() && !light.has_up_end()) return Motion(Transform{});
  const Imath::V3d position = point_of(light.position()),
                   position_end = light.has_position_end() ? point_of(light.position_end()) : position;
  const Imath::V3d axis = point_of(light.target()) - position;
  const Imath::V3d axis_end =
      point_of(light.has_target_end() ? light.target_end() : light.target()) - position_end;
  const v1::Point3& up_end = light.has_up_end() ? light.up_end() : light.up();
  const auto turn = light.texture().empty()
                        ? turn_between(axis, axis_end)
                        : turn_between(axis, point_of(light.up()), axis_end, point_of(up_end));
  if (!turn.ok()) return turn.status();
  return Motion::between(Transform::translation(position), Transform::translation(position_end) * *turn);
}

absl::StatusOr<Motion> motion_of_distant(const v1::DistantLight& light) {
  if (!light.has_direction_end()) return Motion(Transform{});
  const auto turn = turn_between(point_of(light.direction()), point_of(light.direction_end()));
  if (!turn.ok()) return turn.status();
  return Motion::between(Transform{}, *turn);
}

absl::StatusOr<Motion> motion_of_sky(const v1::InfiniteLight& light) {
  if (light.world_from_light_end().elements().empty() || !light.has_image()) return Motion(Transform{});
  if (!light.portal().empty()) return absl::InvalidArgumentError("a light with a portal cannot move");
  Transform places[2];
  const v1::Matrix* matrices[2] = {&light.world_from_light(), &light.world_from_light_end()};
  for (std::size_t i = 0; i < 2; ++i) {
    const auto place = Transform::from_proto(*matrices[i]);
    if (!place.ok()) return place.status();
    const Imath::V3d x = place->apply_vector({1, 0, 0}), y = place->apply_vector({0, 1, 0}),
                     z = place->apply_vector({0, 0, 1});
    const double size = x.length();
    constexpr double kTolerance = 1e-4;
    const double skew =
        std::max({std::abs(y.length() - size), std::abs(z.length() - size), std::abs(x.dot(y)) / size,
                  std::abs(y.dot(z)) / size, std::abs(z.dot(x)) / size});
    if (!(size > 0) || !(skew <= kTolerance * size))
      return absl::InvalidArgumentError("its transform changes angles between directions");
    places[i] = frame_of(x / size, y / size, z / size, {0, 0, 0});
  }
  return Motion::between(places[0], places[1]);
}

MovingLights& LightBuilder::moving() {
  if (moving_ == nullptr) {
    moving_ = std::make_shared<MovingLights>();
    moving_->still.sources = table_.sources;
    moving_->still.shapes = table_.shapes;
    moving_->still.textures = table_.textures;
    table_.moving = moving_;
  }
  moving_->still.any_textures = table_.any_textures;
  moving_->still.lights.resize(table_.lights.size());
  moving_->motion_of_light.resize(table_.lights.size(), -1);
  return *moving_;
}

void LightBuilder::add_moving_records(LightMotion motion, std::vector<LightRecord> own) {
  MovingLights& all = moving();
  const auto number = static_cast<std::int32_t>(all.motions.size());
  all.motions.push_back(motion);
  for (LightRecord& still : own) {
    LightRecord record = still;
    record.kind = moving_kind(still);
    record.profile = static_cast<std::int32_t>(table_.lights.size());
    record.environment = -1;
    // Where a shape is textured is asked where it stands.
    if (still.shape >= 0) still.texture = -1;
    if (is_environment(record.kind)) table_.infinite_lights.push_back(record.profile);
    table_.lights.push_back(record);
    all.still.lights.push_back(still);
    all.motion_of_light.push_back(number);
  }
}

absl::Status LightBuilder::add_moving_light(const Motion& motion, LightRecord record) {
  const bool at_infinity = is_at_infinity(record.kind);
  std::fill_n(record.position, 3, 0.0f);
  const Transform from_world = at_infinity ? Transform{} : inputs_.space.from_world;
  LightMotion steps{.first_step = static_cast<std::int32_t>(moving().steps.size()),
                    .segments = motion.segments()};
  if (auto s = append_steps([&](double time) { return from_world * motion.at(time); }, steps.segments,
                            moving().steps);
      !s.ok())
    return s;
  add_moving_records(steps, {record});
  return absl::OkStatus();
}

const InstanceRecord* place_of_moving_shape(std::int32_t shape, const ShapeTable& shapes) {
  if (shape < shapes.world_shape_count) return nullptr;
  const auto instance = std::ranges::find_if(shapes.instances, [&](const InstanceRecord& one) {
    const ObjectRange& object = shapes.objects[static_cast<std::size_t>(one.object)];
    return one.number == 0 && object.first_shape <= shape && shape < object.first_shape + object.shape_count;
  });
  return instance == shapes.instances.end() ? nullptr : &*instance;
}

void LightBuilder::add_moving_area_light(const Emitter& emitter, const LightRecord& light,
                                         const InstanceRecord& place, ShapeTable& shapes) {
  if (emitter.light->interpolated_normal_pick() > 0 && inputs_.warnings != nullptr)
    inputs_.warnings->push_back(
        absl::StrCat(emitter.where, ": it moves, and emits light by its true normals alone"));
  MovingLights& all = moving();
  // Shapes that move stand before all instances that hold others: the lower part of the number is all of it.
  const LightMotion motion{.first_step = static_cast<std::int32_t>(all.steps.size()),
                           .segments = place.segments,
                           .instance = static_cast<std::int32_t>(place.first_place)};
  const auto first = shapes.motion_steps.begin() + place.first_step;
  all.steps.insert(all.steps.end(), first, first + place.segments + 1);

  LightTable own;
  own.sources = table_.sources;
  own.lights.resize(table_.lights.size());  // numbers are those that they will have
  append_area_lights(shapes, emitter.shape, light.radiance, emitter.light->two_sided(), light.texture, own);
  add_moving_records(
      motion, {own.lights.begin() + static_cast<std::ptrdiff_t>(table_.lights.size()), own.lights.end()});
}

}  // namespace tessera::render
