// Objects, their instances, and what moves. A moving shape is an object of its own, placed by a moving
// instance.
#include <algorithm>
#include <cmath>
#include <limits>

#include "absl/strings/str_cat.h"
#include "render/build/scene_builder.h"

namespace tessera::render {

namespace {

/// Where `start` goes while the shutter is open; `end` may be empty.
absl::StatusOr<Motion> motion_of(const v1::Matrix& start, const v1::Matrix& end) {
  const auto first = Transform::from_proto(start);
  if (!first.ok()) return first.status();
  if (end.elements().empty()) return Motion(*first);
  const auto last = Transform::from_proto(end);
  if (!last.ok()) return last.status();
  return Motion::between(*first, *last);
}

/// x -> -x, which is its own inverse.
Transform point_reflection() {
  Transform t;
  t.m[0] = t.m[5] = t.m[10] = -1;
  return t;
}

}  // namespace

absl::StatusOr<bool> SceneBuilder::moves(const v1::Shape& shape, bool instanced, const std::string& where) {
  if (shape.world_from_object_end().elements().empty()) return false;
  const auto motion = motion_of(shape.world_from_object(), shape.world_from_object_end());
  if (!motion.ok()) return motion.status();
  if (!motion->moves()) return false;
  if (instanced || !shape.has_area_light() || shape.has_curves()) return true;
  warnings_.push_back(absl::StrCat(
      where, ": shapes that emit light do not move; it stays where it is when the shutter opens"));
  return false;
}

absl::StatusOr<SceneBuilder::MovingShape> SceneBuilder::build_moving_shape(const v1::Shape& shape,
                                                                           bool instanced,
                                                                           const std::string& where) {
  auto motion = motion_of(shape.world_from_object(), shape.world_from_object_end());
  if (!motion.ok()) return motion.status();
  // What mirrors is reflected within its object: which side is the front is decided there.
  const bool mirrors = motion->at(0).determinant() < 0;
  const Transform placed_from_object = mirrors ? point_reflection() : Transform{};
  if (mirrors) {
    motion = Motion::between(motion->at(0) * placed_from_object, motion->at(1) * placed_from_object);
    if (!motion.ok()) return motion.status();
  }
  ShapeTable& table = arrays_.shapes;
  const auto first = static_cast<std::int32_t>(table.shapes.size());
  if (auto s = build_shape(shape, placed_from_object, instanced, where); !s.ok()) return s;
  const auto count = static_cast<std::int32_t>(table.shapes.size()) - first;
  if (count == 0) return MovingShape{-1, *motion};
  table.objects.push_back({first, count});
  return MovingShape{static_cast<int>(table.objects.size()) - 1, *motion};
}

absl::Status SceneBuilder::build_moving_shapes(const std::vector<int>& shapes) {
  for (const int i : shapes) {
    const v1::Shape& shape = scene_.shapes(i);
    const std::string where = place_in_scene("shape", i, shape.name());
    const auto moving = build_moving_shape(shape, false, where);
    if (!moving.ok()) return located(moving.status(), where);
    if (moving->object < 0) continue;
    const auto place = [&](double time) { return moving->motion.at(time); };
    if (auto s = add_instance(moving->object, moving->motion.segments(), place); !s.ok())
      return located(s, where);
    instance_names_.resize(arrays_.shapes.instances.size(), where);
  }
  return absl::OkStatus();
}

absl::Status SceneBuilder::build_objects() {
  for (const v1::Object& object : scene_.objects()) {
    if (objects_.contains(object.name())) {
      return absl::InvalidArgumentError(absl::StrCat("object '", object.name(), "': the name is used twice"));
    }
    auto parts = build_object(object);
    if (!parts.ok()) return parts.status();
    objects_[object.name()] = *std::move(parts);
  }
  return absl::OkStatus();
}

absl::StatusOr<Point> SceneBuilder::anchor_of(const v1::Object& object) const {
  if (object.shapes().empty()) return Point{};
  const v1::Shape& first = object.shapes(0);
  const auto instance_from_object = Transform::from_proto(first.world_from_object());
  if (!instance_from_object.ok()) return instance_from_object.status();
  Point low{0, 0, 0}, high{0, 0, 0};
  if (first.has_mesh()) {
    const auto bytes = blobs_(first.mesh().blob().digest());
    if (!bytes.ok()) return bytes.status();
    const auto mesh = wire::decode_mesh(bytes->bytes);
    if (!mesh.ok()) return mesh.status();
    for (std::size_t i = 0; i < mesh->vertex_count(); ++i) {
      const float* v = mesh->positions.data() + 3 * i;
      const Point p = instance_from_object->apply({v[0], v[1], v[2]});
      if (i == 0) low = high = p;
      low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
  } else {
    const Point reach = instance_from_object->apply_vector({1, 1, 1});
    low = instance_from_object->apply({0, 0, 0}) - reach;
    high = instance_from_object->apply({0, 0, 0}) - Point{-reach.x, -reach.y, -reach.z};
  }
  constexpr double kFar = 16;  // sizes of the first shape
  const Point middle{(low.x + high.x) / 2, (low.y + high.y) / 2, (low.z + high.z) / 2};
  return length(middle) > kFar * length(high - low) ? middle : Point{};
}

absl::StatusOr<SceneBuilder::ObjectParts> SceneBuilder::build_object(const v1::Object& object) {
  const auto place = [&](int i) {
    return absl::StrCat("object '", object.name(), "', ",
                        place_in_scene("shape", i, object.shapes(i).name()));
  };
  ShapeTable& table = arrays_.shapes;
  ObjectParts parts;
  const auto anchor = anchor_of(object);
  if (!anchor.ok()) return located(anchor.status(), place(0));
  parts.anchor = *anchor;
  const Transform anchored_from_instance = Transform::translation({-anchor->x, -anchor->y, -anchor->z});
  ObjectRange still{static_cast<std::int32_t>(table.shapes.size()), 0};
  std::vector<int> moving;
  for (int i = 0; i < object.shapes_size(); ++i) {
    const v1::Shape& shape = object.shapes(i);
    const std::string where = place(i);
    const auto moves_too = moves(shape, true, where);
    if (!moves_too.ok()) return located(moves_too.status(), where);
    if (*moves_too) {
      moving.push_back(i);
      continue;
    }
    const auto instance_from_object = Transform::from_proto(shape.world_from_object());
    if (!instance_from_object.ok()) return located(instance_from_object.status(), where);
    if (auto s = build_shape(shape, anchored_from_instance * *instance_from_object, true, where); !s.ok())
      return located(s, where);
  }
  still.shape_count = static_cast<std::int32_t>(table.shapes.size()) - still.first_shape;
  if (still.shape_count > 0) {
    parts.still = static_cast<int>(table.objects.size());
    table.objects.push_back(still);
  }
  for (const int i : moving) {
    const v1::Shape& shape = object.shapes(i);
    const std::string where = place(i);
    auto part = build_moving_shape(shape, true, where);
    if (!part.ok()) return located(part.status(), where);
    if (part->object >= 0) parts.moving.push_back(*std::move(part));
  }
  return parts;
}

absl::Status SceneBuilder::build_instances() {
  int index = 0;
  for (const v1::Instance& instance : scene_.instances()) {
    const std::string where = place_in_scene("instance", index++, instance.object());
    const auto parts = objects_.find(instance.object());
    if (parts == objects_.end()) {
      return absl::InvalidArgumentError(
          absl::StrCat(where, ": object '", instance.object(), "' does not exist"));
    }
    if (auto s = build_instance(instance, parts->second, where); !s.ok()) return located(s, where);
    instance_names_.resize(arrays_.shapes.instances.size(), where);
  }
  return absl::OkStatus();
}

absl::Status SceneBuilder::check_instances(const float* centre, float radius) const {
  const double reach = std::hypot(centre[0], centre[1], centre[2]) + radius;
  constexpr double kFarthest = 1e18;  // Embree's own limit, beyond which it may end the program, is 1.8e18
  for (std::size_t i = 0; i < arrays_.shapes.instances.size(); ++i) {
    const auto& m = arrays_.shapes.instances[i].instance_from_render.m;
    for (int row = 0; row < 3; ++row) {
      const double scale = std::hypot(m[4 * row], m[4 * row + 1], m[4 * row + 2]);
      if (!(scale * reach + std::abs(m[4 * row + 3]) <= kFarthest))
        return located(absl::InvalidArgumentError(kBeyondFloats), instance_names_[i]);
    }
  }
  return absl::OkStatus();
}

absl::Status SceneBuilder::build_instance(const v1::Instance& instance, const ObjectParts& parts,
                                          const std::string& where) {
  const auto motion = motion_of(instance.world_from_instance(), instance.world_from_instance_end());
  if (!motion.ok()) return motion.status();
  Transform unused;
  if (!motion->moves() && !(render_from_world_ * motion->at(0)).invert(unused)) {
    warnings_.push_back(absl::StrCat(where, ": its transform is singular; left out"));
    return absl::OkStatus();
  }
  if (parts.still >= 0) {
    const auto place = [&](double time) { return motion->at(time) * Transform::translation(parts.anchor); };
    if (auto s = add_instance(parts.still, motion->segments(), place); !s.ok()) return s;
  }
  for (const MovingShape& part : parts.moving) {
    const auto place = [&](double time) { return motion->at(time) * part.motion.at(time); };
    if (auto s = add_instance(part.object, segments_of_product(*motion, part.motion), place); !s.ok())
      return s;
  }
  return absl::OkStatus();
}

absl::Status SceneBuilder::add_instance(int object, int segments,
                                        const std::function<Transform(double)>& world_from_instance) {
  ShapeTable& table = arrays_.shapes;
  const Transform start = render_from_world_ * world_from_instance(0);
  Transform back;
  if (!start.invert(back)) return absl::InvalidArgumentError("its transform is singular");
  if (!fits_floats(start, back)) return absl::InvalidArgumentError(kBeyondFloats);
  InstanceRecord record{start.to_affine(), back.to_affine(), object};
  if (segments > 0) {
    // The kernels gather floats with 32-bit indices.
    constexpr std::size_t kMost = std::numeric_limits<std::int32_t>::max() / 12 - Motion::kMostSegments;
    if (table.motion_steps.size() > kMost) return absl::ResourceExhaustedError("too much in the scene moves");
    record.first_step = static_cast<std::int32_t>(table.motion_steps.size());
    record.segments = segments;
    tables_.any_motion = true;
    const auto place = [&](double time) { return render_from_world_ * world_from_instance(time); };
    if (auto s = append_steps(place, segments, table.motion_steps); !s.ok()) return s;
  }
  table.instances.push_back(record);
  return absl::OkStatus();
}

}  // namespace tessera::render
