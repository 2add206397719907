#include "import/input/instance_list.h"

#include <algorithm>
#include <utility>

#include "import/geometry/motion_keys.h"
#include "wire/packed_instances.h"
#include "wire/scene_numbers.h"

namespace tessera::client {
namespace {

/// Nothing for what is no matrix.
std::optional<Imath::M44d> place_of(const v1::Matrix& message) {
  if (message.elements().empty()) return Imath::M44d();
  if (message.elements_size() != 16) return std::nullopt;
  Imath::M44d columns;
  std::copy_n(message.elements().begin(), 16, columns.getValue());
  return columns.transposed();
}

template <class Holder>
void pack_messages(Holder& holder, BlobCollector& blobs) {
  // A scene file that has packed instances keeps its messages beside them.
  if (holder.instances_size() <= static_cast<int>(InstanceList::kMostMessages) ||
      holder.has_packed_instances())
    return;
  InstanceList list;
  google::protobuf::RepeatedPtrField<v1::Instance> with_keys;
  for (const v1::Instance& instance : holder.instances()) {
    if (!instance.motion().empty()) {
      *with_keys.Add() = instance;
      continue;
    }
    const auto start = place_of(instance.world_from_instance());
    const bool moves = !instance.world_from_instance_end().elements().empty();
    const auto end = moves ? place_of(instance.world_from_instance_end()) : start;
    if (!start || !end) return;
    list.add(instance.object(), {*start, *end});
  }
  with_keys.Swap(holder.mutable_instances());
  list.move_to(
      holder, [](const std::string&) { return true; }, blobs);
}

}  // namespace

void InstanceList::add(const std::string& object, const MovingTransform& place) {
  const auto [known, is_new] =
      object_numbers_.try_emplace(object, static_cast<std::uint32_t>(objects_.size()));
  if (is_new) {
    objects_.push_back(object);
    groups_by_object_.emplace_back();
  }
  if (packs_ && add_packed(known->second, place)) return;
  unpacked_.push_back({known->second, place});
  if (packs_ || unpacked_.size() <= kMostMessages) return;
  packs_ = true;
  std::erase_if(unpacked_, [&](const Unpacked& few) { return add_packed(few.object, few.place); });
}

bool InstanceList::add_packed(std::uint32_t object, const MovingTransform& place) {
  const Imath::M44d& m = place.start;
  if (place.moves() || m[0][3] != 0 || m[1][3] != 0 || m[2][3] != 0 || m[3][3] != 1) return false;
  const std::array<double, 16> elements = elements_of(m);
  const auto end = elements.begin() + wire::kPackedElements;
  if (!std::all_of(elements.begin(), end, wire::is_scene_number)) return false;
  groups_by_object_[object].insert(groups_by_object_[object].end(), elements.begin(), end);
  return true;
}

void InstanceList::write_messages(const std::function<bool(const std::string&)>& keeps,
                                  google::protobuf::RepeatedPtrField<v1::Instance>& messages) const {
  for (const Unpacked& instance : unpacked_) {
    const std::string& object = objects_[instance.object];
    if (!keeps(object)) continue;
    v1::Instance& message = *messages.Add();
    message.set_object(object);
    write_matrix(instance.place.start, *message.mutable_world_from_instance());
    write_motion(placings_of(instance.place), &v1::Instance::mutable_world_from_instance_end, message);
  }
}

std::optional<v1::PackedInstances> InstanceList::pack(const std::function<bool(const std::string&)>& keeps,
                                                      BlobCollector& blobs) {
  v1::PackedInstances packed;
  for (std::size_t i = 0; i < groups_by_object_.size(); ++i) {
    if (!keeps(objects_[i])) groups_by_object_[i].clear();
    if (groups_by_object_[i].empty()) continue;
    v1::PackedInstances::Run& run = *packed.add_runs();
    run.set_object(objects_[i]);
    run.set_count(groups_by_object_[i].size() / wire::kPackedElements);
  }
  if (packed.runs().empty()) return std::nullopt;
  *packed.mutable_matrices() = blobs.add_bytes(wire::encode_matrices(std::move(groups_by_object_)));
  packed.mutable_matrices()->set_path("instances.tsi");
  return packed;
}

void pack_instances(v1::Scene& scene, BlobCollector& blobs) {
  if (std::ranges::none_of(scene.animation().tracks(), &v1::Track::has_instance)) pack_messages(scene, blobs);
  for (v1::Object& object : *scene.mutable_objects()) pack_messages(object, blobs);
}

}  // namespace tessera::client
