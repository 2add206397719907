#include "render/build/shape/instance_builder.h"

#include <cmath>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "render/build/shape/geometry.h"
#include "render/build/values/located.h"

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

absl::Status InstanceBuilder::build(const Shapes& shapes, const Objects& objects,
                                    const Instances& instances) {
  const auto place = [&](int i) { return place_in_scene("shape", i, shapes[i].name()); };
  const auto moving = add_still(shapes, space_.from_world, place, false);
  if (!moving.ok()) return moving.status();
  table_.world_shape_count = static_cast<std::int32_t>(table_.shapes.size());
  shapes_before_ = shapes.size();
  for (const v1::Object& object : objects) {
    if (auto s = object_names_.add(object.name(), static_cast<int>(objects_.size())); !s.ok()) return s;
    auto parts = build_object(object);
    if (!parts.ok()) return parts.status();
    objects_.push_back(*std::move(parts));
    shapes_before_ += object.shapes_size();
  }
  if (auto s = add_moving(shapes, *moving); !s.ok()) return s;
  for (int i = 0; i < instances.size(); ++i) {
    const std::string where = place_in_scene("instance", i, instances[i].object());
    const auto object = object_names_.find(instances[i].object());
    if (!object.ok()) return located(object.status(), where);
    const std::size_t first = table_.instances.size();
    if (auto s = build_instance(instances[i], objects_[static_cast<std::size_t>(*object)], where); !s.ok())
      return located(s, where);
    for (std::size_t k = first; k < table_.instances.size(); ++k) table_.instances[k].number = i + 1;
    instance_names_.resize(table_.instances.size(), where);
  }
  return shapes_.add_solids_of_combinations();
}

absl::StatusOr<std::vector<int>> InstanceBuilder::add_still(const Shapes& shapes,
                                                            const Transform& placed_from_shapes,
                                                            const std::function<std::string(int)>& place,
                                                            bool instanced) {
  std::vector<int> moving;
  for (int i = 0; i < shapes.size(); ++i) {
    const v1::Shape& shape = shapes[i];
    const std::string where = place(i);
    const auto moves_too = moves(shape, instanced, where);
    if (!moves_too.ok()) return located(moves_too.status(), where);
    // Half-spaces of an object are instances of their own: they do not count for the size of the scene.
    if (*moves_too || (instanced && shape.has_half_space())) {
      moving.push_back(i);
      continue;
    }
    const auto shapes_from_object = Transform::from_proto(shape.world_from_object());
    if (!shapes_from_object.ok()) return located(shapes_from_object.status(), where);
    if (auto s = add_shape(shape, placed_from_shapes * *shapes_from_object, shapes_before_ + i + 1, instanced,
                           where);
        !s.ok())
      return located(s, where);
  }
  return moving;
}

absl::StatusOr<bool> InstanceBuilder::moves(const v1::Shape& shape, bool instanced,
                                            const std::string& where) {
  if (shape.world_from_object_end().elements().empty()) return false;
  const auto motion = motion_of(shape.world_from_object(), shape.world_from_object_end());
  if (!motion.ok()) return motion.status();
  if (!motion->moves()) return false;
  if (instanced || !shape.has_area_light() || shape.has_curves()) return true;
  warnings_.push_back(absl::StrCat(
      where, ": shapes that emit light do not move; it stays where it is when the shutter opens"));
  return false;
}

absl::Status InstanceBuilder::add_shape(const v1::Shape& shape, const Transform& placed_from_object,
                                        std::int32_t number, bool instanced, const std::string& where) {
  const std::size_t first = table_.shapes.size();
  if (auto s = shapes_.add(shape, placed_from_object, instanced, where); !s.ok()) return s;
  for (std::size_t i = first; i < table_.shapes.size(); ++i) table_.shapes[i].number = number;
  return absl::OkStatus();
}

absl::StatusOr<InstanceBuilder::MovingShape> InstanceBuilder::build_moving_shape(const v1::Shape& shape,
                                                                                 std::int32_t number,
                                                                                 bool instanced,
                                                                                 const std::string& where) {
  auto motion = motion_of(shape.world_from_object(), shape.world_from_object_end());
  if (!motion.ok()) return motion.status();
  // A mirrored shape is reflected within its object: which side is the front is decided there.
  const bool mirrors = motion->at(0).determinant() < 0;
  const Transform placed_from_object = mirrors ? point_reflection() : Transform{};
  if (mirrors) {
    motion = Motion::between(motion->at(0) * placed_from_object, motion->at(1) * placed_from_object);
    if (!motion.ok()) return motion.status();
  }
  const auto first = static_cast<std::int32_t>(table_.shapes.size());
  if (auto s = add_shape(shape, placed_from_object, number, instanced, where); !s.ok()) return s;
  const auto count = static_cast<std::int32_t>(table_.shapes.size()) - first;
  if (count == 0) return MovingShape{-1, *motion};
  table_.objects.push_back({first, count});
  return MovingShape{static_cast<int>(table_.objects.size()) - 1, *motion};
}

absl::Status InstanceBuilder::add_moving(const Shapes& shapes, const std::vector<int>& moving) {
  for (const int i : moving) {
    const std::string where = place_in_scene("shape", i, shapes[i].name());
    const auto shape = build_moving_shape(shapes[i], i + 1, false, where);
    if (!shape.ok()) return located(shape.status(), where);
    if (shape->object < 0) continue;
    const auto place = [&](double time) { return shape->motion.at(time); };
    if (auto s = add_instance(shape->object, shape->motion.segments(), place); !s.ok())
      return located(s, where);
    instance_names_.resize(table_.instances.size(), where);
  }
  return absl::OkStatus();
}

absl::StatusOr<Imath::V3d> InstanceBuilder::anchor_of(const v1::Object& object) const {
  if (object.shapes().empty()) return Imath::V3d(0, 0, 0);
  const v1::Shape& first = object.shapes(0);
  const auto instance_from_object = Transform::from_proto(first.world_from_object());
  if (!instance_from_object.ok()) return instance_from_object.status();
  Imath::V3d low(0, 0, 0), high(0, 0, 0);
  if (first.has_mesh()) {
    const auto bounds = bounds_of_mesh(first.mesh(), *instance_from_object, blobs_);
    if (!bounds.ok()) return bounds.status();
    std::tie(low, high) = *bounds;
  } else {
    const Imath::V3d reach = instance_from_object->apply_vector({1, 1, 1});
    low = instance_from_object->apply({0, 0, 0}) - reach;
    high = instance_from_object->apply({0, 0, 0}) + reach;
  }
  constexpr double kFar = 16;  // sizes of the first shape
  const Imath::V3d middle = (low + high) / 2;
  return middle.length() > kFar * (high - low).length() ? middle : Imath::V3d(0, 0, 0);
}

absl::StatusOr<InstanceBuilder::ObjectParts> InstanceBuilder::build_object(const v1::Object& object) {
  const auto place = [&](int i) {
    return absl::StrCat("object '", object.name(), "', ",
                        place_in_scene("shape", i, object.shapes(i).name()));
  };
  ObjectParts parts;
  const auto anchor = anchor_of(object);
  if (!anchor.ok()) return located(anchor.status(), place(0));
  parts.anchor = *anchor;
  const auto first = static_cast<std::int32_t>(table_.shapes.size());
  const auto moving =
      add_still(object.shapes(), Transform::translation({-anchor->x, -anchor->y, -anchor->z}), place, true);
  if (!moving.ok()) return moving.status();
  if (const auto count = static_cast<std::int32_t>(table_.shapes.size()) - first; count > 0) {
    parts.still = static_cast<int>(table_.objects.size());
    table_.objects.push_back({first, count});
  }
  for (const int i : *moving) {
    auto part = build_moving_shape(object.shapes(i), shapes_before_ + i + 1, true, place(i));
    if (!part.ok()) return located(part.status(), place(i));
    if (part->object >= 0) parts.moving.push_back(*std::move(part));
  }
  return parts;
}

absl::Status InstanceBuilder::check_reach(const float* centre, float radius) const {
  const double reach = std::hypot(centre[0], centre[1], centre[2]) + radius;
  constexpr double kFarthest = 1e18;  // Embree's own limit, beyond which it may end the program, is 1.8e18
  for (std::size_t i = 0; i < table_.instances.size(); ++i) {
    const auto& m = table_.instances[i].instance_from_render.m;
    for (int row = 0; row < 3; ++row) {
      const double scale = std::hypot(m[4 * row], m[4 * row + 1], m[4 * row + 2]);
      if (!(scale * reach + std::abs(m[4 * row + 3]) <= kFarthest))
        return located(absl::InvalidArgumentError(kBeyondFloats), instance_names_[i]);
    }
  }
  return absl::OkStatus();
}

absl::Status InstanceBuilder::build_instance(const v1::Instance& instance, const ObjectParts& parts,
                                             const std::string& where) {
  const auto motion = motion_of(instance.world_from_instance(), instance.world_from_instance_end());
  if (!motion.ok()) return motion.status();
  Transform unused;
  if (!motion->moves() && !(space_.from_world * motion->at(0)).invert(unused)) {
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

absl::Status InstanceBuilder::add_instance(int object, int segments,
                                           const std::function<Transform(double)>& world_from_instance) {
  const Transform start = space_.from_world * world_from_instance(0);
  Transform back;
  if (!start.invert(back)) return absl::InvalidArgumentError("its transform is singular");
  if (!fits_floats(start, back)) return absl::InvalidArgumentError(kBeyondFloats);
  const auto first = static_cast<std::size_t>(table_.objects[static_cast<std::size_t>(object)].first_shape);
  if (is_unbounded(table_.shapes[first])) {
    const QuadricRecord& plane = table_.quadrics[static_cast<std::size_t>(table_.shapes[first].quadric)];
    const double reach = plane.radius * largest_scale(plane.render_from_object);
    if (!(reach * largest_scale(start.to_affine()) <= kFarthestPlane))
      return absl::InvalidArgumentError(kBeyondFloats);
  }
  InstanceRecord record{start.to_affine(), back.to_affine(), object};
  if (segments > 0) {
    // The kernels gather floats with 32-bit indices.
    constexpr std::size_t kMost = std::numeric_limits<std::int32_t>::max() / 12 - Motion::kMostSegments;
    if (table_.motion_steps.size() > kMost)
      return absl::ResourceExhaustedError("too much in the scene moves");
    record.first_step = static_cast<std::int32_t>(table_.motion_steps.size());
    record.segments = segments;
    const auto place = [&](double time) { return space_.from_world * world_from_instance(time); };
    if (auto s = append_steps(place, segments, table_.motion_steps); !s.ok()) return s;
  }
  table_.instances.push_back(record);
  return absl::OkStatus();
}

}  // namespace tessera::render
