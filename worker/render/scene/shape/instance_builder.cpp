#include "render/scene/shape/instance_builder.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "render/core/stopped.h"
#include "render/scene/shape/geometry.h"
#include "render/scene/shape/object_graph.h"
#include "render/scene/values/located.h"
#include "render/shape/place.h"
#include "wire/packed_instances.h"

namespace tessera::render {

namespace {

/// Makes room for `more` records at once: where they are many, copies of the array would be the peak.
void reserve(std::size_t more, std::vector<InstanceRecord>& records) {
  const std::size_t wanted = records.size() + more, grown = records.capacity() + records.capacity() / 2;
  if (wanted > records.capacity()) records.reserve(std::max(wanted, grown));
}

/// Up to so many, meshes that move are objects: rays that meet one search a tree that stands still. Where
/// many move, rays would go through the boxes of many objects (decision 0066 has figures).
constexpr int kFewMovingMeshes = 8;
/// Each step is a copy of the mesh's vertices: meshes that move may have so many bytes with all of their
/// steps.
constexpr int kMostStepsAsKeys = 8;
constexpr double kMostBytesOfKeys = 1 << 30;

/// Whether a shape moves and may be a mesh with keys: between two steps, vertices go as straight as matrices
/// do.
bool may_have_keys(const v1::Shape& shape, const Motion& motion) {
  return motion.moves() && motion.segments() <= kMostStepsAsKeys && shape.has_mesh() &&
         shape.mesh().later_blobs().empty() && !shape.has_area_light();
}

/// x -> -x, which is its own inverse.
Transform point_reflection() {
  Transform t;
  t.m[0] = t.m[5] = t.m[10] = -1;
  return t;
}

}  // namespace

absl::Status InstanceBuilder::build(const v1::Scene& scene, v1::Nesting asked,
                                    const std::string& wants_flat) {
  scene_ = &scene;
  if (auto s = read_all_instances(); !s.ok()) return s;
  const Shapes& shapes = scene.shapes();
  const auto place = [&](int i) { return place_in_scene("shape", i, shapes[i].name()); };
  if (auto s = count_moving_meshes(shapes); !s.ok()) return s;
  const auto moving = add_still(shapes, space_.from_world, place, false);
  if (!moving.ok()) return moving.status();
  table_.world_shape_count = static_cast<std::int32_t>(table_.shapes.size());
  shapes_before_ = shapes.size();
  std::vector<std::uint64_t> own_parts, alone;
  for (const v1::Object& object : scene.objects()) {
    if (auto s = object_names_.add(object.name(), static_cast<int>(object_parts_.size())); !s.ok()) return s;
    auto parts = build_object(object);
    if (!parts.ok()) return parts.status();
    own_parts.push_back(parts->size());
    alone.push_back(static_cast<std::uint64_t>(
        std::ranges::count_if(*parts, [&](const auto& part) { return stands_alone(part); })));
    object_parts_.push_back(*std::move(parts));
    shapes_before_ += object.shapes_size();
  }
  if (auto s = add_moving(shapes, *moving); !s.ok()) return s;

  // Objects within objects.
  const auto graph = ObjectGraph::of(scene.objects(), object_names_);
  if (!graph.ok()) return graph.status();
  if (auto s = append_held(scene, object_names_, "", placed_); !s.ok()) return s;
  if (auto s = check_flattened(*graph, alone, placed_, "half-spaces and lights of objects"); !s.ok())
    return s;
  auto plan = plan_nesting(*graph, own_parts, placed_, asked, wants_flat);
  if (!plan.ok()) return plan.status();
  note_ = std::move(plan->note);
  uses_ = std::move(plan->uses);
  for (const int object : graph->order()) {
    if (uses_[static_cast<std::size_t>(object)] == 0) continue;
    const auto& held = graph->held_by(object);
    if (auto s = add_held(object, held, plan->kept[static_cast<std::size_t>(object)]); !s.ok()) return s;
  }
  if (auto s = add_world_instances(plan->world_kept); !s.ok()) return s;
  written_world_ = {}, written_objects_ = {};  // whoever owns the blobs may free them
  move_lamps_forward();
  number_places(table_);
  return shapes_.add_solids_of_combinations();
}

absl::StatusOr<std::vector<int>> InstanceBuilder::add_still(const Shapes& shapes,
                                                            const Transform& placed_from_shapes,
                                                            const std::function<std::string(int)>& place,
                                                            bool instanced) {
  std::vector<int> moving;
  for (int i = 0; i < shapes.size(); ++i) {
    throw_if_stopped(stop_);
    const v1::Shape& shape = shapes[i];
    const std::string where = place(i);
    const auto motion = Motion::of(shape);
    if (!motion.ok()) return located(motion.status(), where);
    std::vector<Transform> later_places;
    if (meshes_have_keys_ && !instanced && may_have_keys(shape, *motion)) {
      for (int step = 1; step <= motion->segments(); ++step)
        later_places.push_back(placed_from_shapes *
                               motion->at(static_cast<double>(step) / motion->segments()));
      warn_of_roughness(motion->steps(), where);
    } else if (motion->moves() || (instanced && (shape.has_half_space() || shape.has_area_light()))) {
      moving.push_back(i);
      continue;
    }
    if (auto s = add_shape(shape, placed_from_shapes * motion->at(0), shapes_before_ + i + 1, instanced,
                           where, later_places);
        !s.ok())
      return located(s, where);
  }
  return moving;
}

absl::Status InstanceBuilder::count_moving_meshes(const Shapes& shapes) {
  int count = 0;
  double bytes = 0;
  for (int i = 0; i < shapes.size(); ++i) {
    const auto motion = Motion::of(shapes[i]);
    if (!motion.ok()) return located(motion.status(), place_in_scene("shape", i, shapes[i].name()));
    if (!may_have_keys(shapes[i], *motion)) continue;
    ++count;
    bytes += static_cast<double>(shapes[i].mesh().blob().size_bytes()) * (motion->segments() + 1);
  }
  meshes_have_keys_ = count > kFewMovingMeshes && bytes <= kMostBytesOfKeys;
  return absl::OkStatus();
}

bool InstanceBuilder::stands_alone(const ObjectPart& part) const {
  const ObjectRange& object = table_.objects[static_cast<std::size_t>(part.object)];
  return is_unbounded(table_, object) ||
         (object.shape_count == 1 && shapes_.waits_for_places(object.first_shape));
}

absl::Status InstanceBuilder::own_emitter(ObjectPart& part) {
  const ObjectRange object = table_.objects[static_cast<std::size_t>(part.object)];
  if (object.shape_count != 1 || !shapes_.waits_for_places(object.first_shape)) return absl::OkStatus();
  const auto shape = shapes_.place_emitter(object.first_shape);
  if (!shape.ok()) return shape.status();
  if (*shape != object.first_shape) {
    part.object = static_cast<std::int32_t>(table_.objects.size());
    table_.objects.push_back({*shape, 1});
  }
  lamps_.insert(part.object);
  return absl::OkStatus();
}

void InstanceBuilder::move_lamps_forward() {
  if (lamps_.empty() || !table_.nested()) return;
  std::stable_partition(table_.instances.begin() + std::ssize(moving_names_), table_.instances.end(),
                        [&](const InstanceRecord& one) { return lamps_.contains(one.object); });
}

absl::Status InstanceBuilder::add_shape(const v1::Shape& shape, const Transform& placed_from_object,
                                        std::int32_t number, bool instanced, const std::string& where,
                                        std::span<const Transform> later_places) {
  const std::size_t first = table_.shapes.size();
  if (auto s = shapes_.add(shape, placed_from_object, instanced, where, later_places); !s.ok()) return s;
  for (std::size_t i = first; i < table_.shapes.size(); ++i) table_.shapes[i].number = number;
  return absl::OkStatus();
}

void InstanceBuilder::warn_of_roughness(const MotionSteps& steps, const std::string& where) {
  const std::string roughness = roughness_of(steps);
  if (!roughness.empty()) warnings_.push_back(absl::StrCat(where, ": ", roughness));
}

absl::StatusOr<ObjectPart> InstanceBuilder::build_moving_shape(const v1::Shape& shape, std::int32_t number,
                                                               bool instanced, const std::string& where) {
  auto motion = Motion::of(shape);
  if (!motion.ok()) return motion.status();
  warn_of_roughness(motion->steps(), where);
  // A mirrored shape is reflected within its object: which side is the front is decided there.
  const bool mirrors = motion->at(0).determinant() < 0;
  const Transform placed_from_object = mirrors ? point_reflection() : Transform{};
  if (mirrors) {
    motion = motion->of_reflected();
    if (!motion.ok()) return motion.status();
  }
  const auto first = static_cast<std::int32_t>(table_.shapes.size());
  if (auto s = add_shape(shape, placed_from_object, number, instanced, where); !s.ok()) return s;
  const auto count = static_cast<std::int32_t>(table_.shapes.size()) - first;
  if (count == 0) return ObjectPart{};
  table_.objects.push_back({first, count});
  return ObjectPart{static_cast<std::int32_t>(table_.objects.size()) - 1, {}, {}}.placed_by(*motion);
}

absl::Status InstanceBuilder::add_moving(const Shapes& shapes, const std::vector<int>& moving) {
  for (const int i : moving) {
    const std::string where = place_in_scene("shape", i, shapes[i].name());
    const auto shape = build_moving_shape(shapes[i], i + 1, false, where);
    if (!shape.ok()) return located(shape.status(), where);
    if (shape->object < 0) continue;
    if (auto s = add_instance(*shape, {space_.from_world, table_.instances}); !s.ok())
      return located(s, where);
    moving_names_.push_back(where);
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
  const auto first = static_cast<std::int32_t>(table_.shapes.size());
  const auto moving =
      add_still(object.shapes(), Transform::translation({-anchor->x, -anchor->y, -anchor->z}), place, true);
  if (!moving.ok()) return moving.status();
  if (const auto count = static_cast<std::int32_t>(table_.shapes.size()) - first; count > 0) {
    parts.push_back({static_cast<std::int32_t>(table_.objects.size()), Transform::translation(*anchor), {}});
    table_.objects.push_back({first, count});
  }
  for (const int i : *moving) {
    auto part = build_moving_shape(object.shapes(i), shapes_before_ + i + 1, true, place(i));
    if (!part.ok()) return located(part.status(), place(i));
    if (part->object >= 0) parts.push_back(*std::move(part));
  }
  return parts;
}

std::size_t InstanceBuilder::Written::size() const {
  const auto count = messages == nullptr ? 0 : static_cast<std::size_t>(messages->size());
  return count + packed.size() / wire::kPackedElements;
}

absl::StatusOr<Motion> InstanceBuilder::Written::motion(std::size_t i) const {
  const auto count = static_cast<std::size_t>(messages->size());
  if (i < count) return Motion::of((*messages)[static_cast<int>(i)]);
  Transform place;
  std::copy_n(packed.begin() + static_cast<std::ptrdiff_t>((i - count) * wire::kPackedElements),
              wire::kPackedElements, place.m.begin());
  return Motion(place);
}

template <class Message>
absl::StatusOr<InstanceBuilder::Written> InstanceBuilder::read_instances(const Message& holder) const {
  Written written{.messages = &holder.instances(), .blob = {}, .packed = {}};
  if (!holder.has_packed_instances()) return written;
  auto blob = blobs_(holder.packed_instances().matrices().digest());
  if (!blob.ok()) return located(blob.status(), "packed instances");
  written.blob = *std::move(blob);
  const auto packed = wire::decode_matrices(holder.packed_instances(), written.blob.bytes);
  if (!packed.ok()) return packed.status();
  written.packed = *packed;
  return written;
}

absl::Status InstanceBuilder::read_all_instances() {
  auto world = read_instances(*scene_);
  if (!world.ok()) return world.status();
  written_world_ = *std::move(world);
  for (const v1::Object& object : scene_->objects()) {
    auto written = read_instances(object);
    if (!written.ok()) return located(written.status(), absl::StrCat("object '", object.name(), "'"));
    written_objects_.push_back(*std::move(written));
  }
  return absl::OkStatus();
}

template <class F>
absl::Status InstanceBuilder::for_each_placed(const Written& instances, const std::vector<int>& objects,
                                              const std::string& where, F&& f) {
  for (std::size_t i = 0; i < instances.size(); ++i) {
    const auto object = static_cast<std::size_t>(objects[i]);
    const auto place = [&] {
      const std::string& name = scene_->objects(objects[i]).name();
      return where + place_in_scene("instance", static_cast<int>(i), name);
    };
    const auto motion = instances.motion(i);
    if (!motion.ok()) return located(motion.status(), place());
    Transform unused;
    if (!motion->moves() && !(space_.from_world * motion->at(0)).invert(unused)) {
      warnings_.push_back(absl::StrCat(place(), ": its transform is singular; left out"));
      continue;
    }
    for (const ObjectPart& part : object_parts_[object]) {
      ObjectPart placed = part.placed_by(*motion);
      if (motion->moves()) warn_of_roughness(placed.steps(), place());
      if (auto s = f(i, std::move(placed)); !s.ok()) return located(s, place());
    }
    // With those that are done with gone, all lists together are no longer than the world's.
    if (--uses_[object] == 0) object_parts_[object] = {};
  }
  return absl::OkStatus();
}

absl::Status InstanceBuilder::add_held(int object, const std::vector<int>& held, bool kept) {
  if (held.empty()) return absl::OkStatus();
  const v1::Object& message = scene_->objects(object);
  const Written& written = written_objects_[static_cast<std::size_t>(object)];
  const std::string where = absl::StrCat("object '", message.name(), "'");
  ObjectParts& own = object_parts_[static_cast<std::size_t>(object)];
  ObjectParts outside;  // parts that the holders place
  const auto anchor = kept ? anchor_of_group(written) : Imath::V3d(0, 0, 0);
  if (!anchor.ok()) return located(anchor.status(), where);
  const auto first = static_cast<std::int32_t>(table_.inner.size());
  const Holder group{Transform::translation(-*anchor), table_.inner};
  const auto add = [&](ObjectPart part) {
    if (kept && !stands_alone(part)) return add_instance(part, group);
    outside.push_back(std::move(part));
    return absl::OkStatus();
  };
  for (ObjectPart& part : own) {
    if (auto s = add(std::move(part)); !s.ok()) return located(s, where);
  }
  if (kept) reserve(held.size(), table_.inner);
  if (auto s = for_each_placed(written, held, absl::StrCat(where, ", "),
                               [&](std::size_t, ObjectPart part) { return add(std::move(part)); });
      !s.ok())
    return s;
  if (const auto count = static_cast<std::int32_t>(table_.inner.size()) - first; count > 0) {
    outside.push_back(
        {static_cast<std::int32_t>(table_.objects.size()), Transform::translation(*anchor), {}});
    table_.objects.push_back({0, 0, first, count});
    groups_.push_back({table_.objects.size() - 1, absl::StrCat("an instance in ", where)});
  }
  own = std::move(outside);
  return absl::OkStatus();
}

absl::StatusOr<Imath::V3d> InstanceBuilder::anchor_of_group(const Written& instances) {
  Imath::V3d at[2];
  const std::size_t ends[2] = {0, instances.size() - 1};
  for (int i = 0; i < 2; ++i) {
    const auto motion = instances.motion(ends[i]);
    if (!motion.ok()) return motion.status();
    at[i] = motion->at(0).apply({0, 0, 0});
  }
  constexpr double kFar = 16;  // ways from the first to the last
  return at[0].length() > kFar * (at[1] - at[0]).length() ? at[0] : Imath::V3d(0, 0, 0);
}

absl::Status InstanceBuilder::add_world_instances(bool kept) {
  const Holder world{space_.from_world, table_.instances}, group{space_.from_world, table_.inner};
  reserve(placed_.size(), kept ? table_.inner : table_.instances);
  const auto first = static_cast<std::int32_t>(table_.inner.size());
  const auto add = [&](std::size_t i, ObjectPart part) {
    const Holder& holder = kept && !stands_alone(part) ? group : world;
    if (auto s = own_emitter(part); !s.ok()) return s;
    if (auto s = add_instance(part, holder); !s.ok()) return s;
    holder.records.back().number = static_cast<std::int32_t>(i) + 1;
    return absl::OkStatus();
  };
  if (auto s = for_each_placed(written_world_, placed_, "", add); !s.ok()) return s;
  const auto count = static_cast<std::int32_t>(table_.inner.size()) - first;
  if (count == 0) return absl::OkStatus();
  const auto object = static_cast<std::int32_t>(table_.objects.size());
  table_.objects.push_back({0, 0, first, count});
  groups_.push_back({table_.objects.size() - 1, "an instance"});
  const Holder render_space{Transform{}, table_.instances};
  return add_instance({object, Transform{}, {}}, render_space);
}

std::string InstanceBuilder::name_of_instance(std::size_t index) const {
  if (index < moving_names_.size()) return moving_names_[index];
  const int i = table_.instances[index].number - 1;
  if (i < 0) return "the world's instances";
  return place_in_scene("instance", i, scene_->objects(placed_[static_cast<std::size_t>(i)]).name());
}

absl::Status InstanceBuilder::check_reach(const float* centre, float radius) const {
  constexpr double kFarthest = 1e18;   // Embree's own limit, beyond which it may end the program, is 1.8e18
  constexpr double kMostScale = 1e12;  // several levels together: determinants are floats still
  struct Reach {
    double radius = 0;             // about the object's origin: of rays in its space
    double scale = 0, shrink = 0;  // largest, of all ways there and back
  };
  std::vector<Reach> reaches(table_.objects.size());
  const auto look = [&](const InstanceRecord& instance, const Reach& holder) {
    const auto& m = instance.instance_from_render.m;
    double squared = 0;
    for (int row = 0; row < 3; ++row) {
      const double coordinate =
          std::hypot(m[4 * row], m[4 * row + 1], m[4 * row + 2]) * holder.radius + std::abs(m[4 * row + 3]);
      if (!(coordinate <= kFarthest)) return false;
      squared += coordinate * coordinate;
    }
    Reach& own = reaches[static_cast<std::size_t>(instance.object)];
    own.radius = std::max(own.radius, std::sqrt(squared));
    if (!table_.nested()) return true;
    own.scale = std::max(own.scale, holder.scale * largest_scale(instance.render_from_instance));
    own.shrink = std::max(own.shrink, holder.shrink * largest_scale(instance.instance_from_render));
    return own.scale <= kMostScale && own.shrink <= kMostScale;
  };
  const Reach world{std::hypot(centre[0], centre[1], centre[2]) + radius, 1, 1};
  for (std::size_t i = 0; i < table_.instances.size(); ++i) {
    if (!look(table_.instances[i], world))
      return located(absl::InvalidArgumentError(kBeyondFloats), name_of_instance(i));
  }
  // Groups come after those that they hold.
  for (auto group = groups_.rbegin(); group != groups_.rend(); ++group) {
    const Reach own = reaches[group->object];
    for (const InstanceRecord& inner : table_.inner_of(table_.objects[group->object])) {
      if (!look(inner, own)) return located(absl::InvalidArgumentError(kBeyondFloats), group->name);
    }
  }
  return absl::OkStatus();
}

absl::Status InstanceBuilder::add_instance(const ObjectPart& part, const Holder& holder) {
  throw_if_stopped(stop_, holder.records.size());
  const auto place_at = [&](double time) { return holder.from_space * part.at(time); };
  const int object = part.object, segments = part.steps().segments;
  const Transform start = place_at(0);
  Transform back;
  if (!start.invert(back)) return absl::InvalidArgumentError("its transform is singular");
  if (!fits_floats(start, back)) return absl::InvalidArgumentError(kBeyondFloats);
  const ObjectRange& range = table_.objects[static_cast<std::size_t>(object)];
  if (is_unbounded(table_, range)) {
    const auto first = static_cast<std::size_t>(range.first_shape);
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
    if (auto s = append_steps(place_at, segments, table_.motion_steps); !s.ok()) return s;
  }
  holder.records.push_back(record);
  return absl::OkStatus();
}

}  // namespace tessera::render
