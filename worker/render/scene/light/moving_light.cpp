// Lights that move: the way of each from its own space to render space, and its records there and here.
#include "render/scene/light/moving_light.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
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

/// Relative to the lengths of axes: angles within it are those of a turn that is written with few digits.
constexpr double kSkewTolerance = 1e-4;

bool keeps_angles(const Transform& place) {
  const Imath::V3d x = place.apply_vector({1, 0, 0}), y = place.apply_vector({0, 1, 0}),
                   z = place.apply_vector({0, 0, 1});
  const double size = x.length();
  const double skew =
      std::max({std::abs(y.length() - size), std::abs(z.length() - size), std::abs(x.dot(y)) / size,
                std::abs(y.dot(z)) / size, std::abs(z.dot(x)) / size});
  return size > 0 && skew <= kSkewTolerance * size;
}

constexpr char kSkewed[] = "its transform changes angles between directions";

Transform without_shift(Transform place) {
  place.m[3] = place.m[7] = place.m[11] = 0;
  return place;
}

/// Keys place the space that `start` places when the shutter opens. `within` is where the light stands in
/// that space. It turns and shifts, or only turns.
absl::StatusOr<LightWay> way_by_keys(const MotionKeys& keys, const Transform& start, const Imath::V3d& within,
                                     LightWay::Follows follows) {
  std::vector<std::string> faults;
  std::vector<Motion::Key> ways = Motion::read_keys(keys, start, faults);
  const bool turns = follows == LightWay::Follows::kTurns;
  const auto of_light = [&](const Transform& place) {
    return turns ? without_shift(place) : place * Transform::translation(within);
  };
  for (std::size_t i = 0; i < ways.size(); ++i) {
    // Those that are singular are told of by the motion.
    if (ways[i].place.determinant() != 0 && !keeps_angles(ways[i].place))
      faults.push_back(absl::StrCat("motion key ", i, ": ", kSkewed));
    ways[i].place = of_light(ways[i].place);
    ways[i].turn.about = turns ? Imath::V3d(0, 0, 0) : ways[i].turn.about - within;
  }
  auto motion = Motion::through(of_light(start), std::move(ways));
  if (!motion.ok()) faults.emplace_back(motion.status().message());
  if (!faults.empty()) return absl::InvalidArgumentError(absl::StrJoin(faults, "; "));
  return LightWay{*std::move(motion), follows};
}

absl::StatusOr<LightWay> way_between(const Transform& start, const Transform& end) {
  auto motion = Motion::between(start, end);
  if (!motion.ok()) return motion.status();
  return LightWay{*std::move(motion)};
}

}  // namespace

Transform LightWay::at(double time) const {
  Transform place = motion.at(time);
  if (follows == Follows::kAll) return place;
  const double size = place.apply_vector({1, 0, 0}).length();
  for (std::size_t i = 0; i < 12; ++i)
    if (i % 4 != 3) place.m[i] /= size;
  return follows == Follows::kTurns ? without_shift(place) : place;
}

absl::StatusOr<LightWay> way_of_point(const v1::PointLight& light, const MotionKeys& keys) {
  if (!keys.empty()) {
    if (light.has_position_end()) return Motion::said_twice();
    return way_by_keys(keys, Transform{}, point_of(light.position()), LightWay::Follows::kRigid);
  }
  if (!light.has_position_end()) return LightWay();
  return way_between(Transform::translation(point_of(light.position())),
                     Transform::translation(point_of(light.position_end())));
}

absl::StatusOr<LightWay> way_of_spot(const v1::SpotLight& light, const MotionKeys& keys) {
  const bool has_end = light.has_position_end() || light.has_target_end() || light.has_up_end();
  const Imath::V3d position = point_of(light.position());
  if (!keys.empty()) {
    if (has_end) return Motion::said_twice();
    return way_by_keys(keys, Transform{}, position, LightWay::Follows::kRigid);
  }
  if (!has_end) return LightWay();
  const Imath::V3d position_end = light.has_position_end() ? point_of(light.position_end()) : position;
  const Imath::V3d axis = point_of(light.target()) - position;
  const Imath::V3d axis_end =
      point_of(light.has_target_end() ? light.target_end() : light.target()) - position_end;
  const v1::Point3& up_end = light.has_up_end() ? light.up_end() : light.up();
  const auto turn = light.texture().empty()
                        ? turn_between(axis, axis_end)
                        : turn_between(axis, point_of(light.up()), axis_end, point_of(up_end));
  if (!turn.ok()) return turn.status();
  return way_between(Transform::translation(position), Transform::translation(position_end) * *turn);
}

absl::StatusOr<LightWay> way_of_distant(const v1::DistantLight& light, const MotionKeys& keys) {
  if (!keys.empty()) {
    if (light.has_direction_end()) return Motion::said_twice();
    return way_by_keys(keys, Transform{}, {0, 0, 0}, LightWay::Follows::kTurns);
  }
  if (!light.has_direction_end()) return LightWay();
  const auto turn = turn_between(point_of(light.direction()), point_of(light.direction_end()));
  if (!turn.ok()) return turn.status();
  return way_between(Transform{}, *turn);
}

absl::StatusOr<LightWay> way_of_sky(const v1::InfiniteLight& light, const MotionKeys& keys) {
  const bool has_end = !light.world_from_light_end().elements().empty();
  if (keys.empty() && (!has_end || !light.has_image())) return LightWay();
  if (has_end && !keys.empty()) return Motion::said_twice();
  if (!light.portal().empty()) return absl::InvalidArgumentError("a light with a portal cannot move");
  const auto start = Transform::from_proto(light.world_from_light());
  if (!start.ok()) return start.status();
  if (light.has_image() && !keeps_angles(*start)) return absl::InvalidArgumentError(kSkewed);
  if (!keys.empty()) {
    auto way = way_by_keys(keys, *start, {0, 0, 0}, LightWay::Follows::kTurns);
    // A sky of one colour looks the same whatever its way.
    return way.ok() && !light.has_image() ? LightWay() : way;
  }
  const auto end = Transform::from_proto(light.world_from_light_end());
  if (!end.ok()) return end.status();
  if (!keeps_angles(*end)) return absl::InvalidArgumentError(kSkewed);
  const auto rotation = [](const Transform& place) {
    const Imath::V3d x = place.apply_vector({1, 0, 0}), y = place.apply_vector({0, 1, 0}),
                     z = place.apply_vector({0, 0, 1});
    const double size = x.length();
    return frame_of(x / size, y / size, z / size, {0, 0, 0});
  };
  return way_between(rotation(*start), rotation(*end));
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

absl::Status LightBuilder::add_moving_light(const LightWay& way, LightRecord record) {
  const bool at_infinity = is_at_infinity(record.kind);
  std::fill_n(record.position, 3, 0.0f);
  const Transform from_world = at_infinity ? Transform{} : inputs_.space.from_world;
  LightMotion steps{.first_step = static_cast<std::int32_t>(moving().steps.size()),
                    .segments = way.motion.segments()};
  if (auto s = append_steps([&](double time) { return from_world * way.at(time); }, steps.segments,
                            moving().steps);
      !s.ok())
    return s;
  roughness_ = roughness_of(way.motion.steps());
  moving().moves = true;
  add_moving_records(steps, {record});
  return absl::OkStatus();
}

std::vector<std::int32_t> instances_by_shape(const ShapeTable& shapes) {
  std::vector<std::int32_t> instances(shapes.shapes.size(), -1);
  for (std::size_t i = 0; i < shapes.instances.size(); ++i) {
    const ObjectRange& object = shapes.objects[static_cast<std::size_t>(shapes.instances[i].object)];
    if (object.shape_count == 1)
      instances[static_cast<std::size_t>(object.first_shape)] = static_cast<std::int32_t>(i);
  }
  return instances;
}

void LightBuilder::add_moving_area_light(const Emitter& emitter, const LightRecord& light,
                                         const InstanceRecord& place, ShapeTable& shapes) {
  if (emitter.light->interpolated_normal_pick() > 0 && inputs_.warnings != nullptr)
    inputs_.warnings->push_back(
        absl::StrCat(emitter.where, ": it moves or is instanced, and emits light by its true normals alone"));
  MovingLights& all = moving();
  // Shapes that emit light stand before all instances that hold others: the lower part of the number is all
  // of it. Those that stand still within an instance go from its place to the same.
  const LightMotion motion{.first_step = static_cast<std::int32_t>(all.steps.size()),
                           .segments = std::max(place.segments, 1),
                           .instance = static_cast<std::int32_t>(place.first_place)};
  if (place.segments > 0) {
    const auto first = shapes.motion_steps.begin() + place.first_step;
    all.steps.insert(all.steps.end(), first, first + place.segments + 1);
    all.moves = true;
  } else {
    all.steps.insert(all.steps.end(), 2, place.render_from_instance);
  }

  LightTable own;
  own.sources = table_.sources;
  own.lights.resize(table_.lights.size());  // numbers are those that they will have
  append_area_lights(shapes, emitter.shape, light.radiance, emitter.light->two_sided(), light.texture, own);
  add_moving_records(
      motion, {own.lights.begin() + static_cast<std::ptrdiff_t>(table_.lights.size()), own.lights.end()});
}

}  // namespace tessera::render
