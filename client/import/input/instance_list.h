// Instances on their way into a scene: a message each where they are few, packed where they are many.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "import/geometry/transform.h"
#include "import/input/blob_collector.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::client {

/// The instances of the world, or those in one object, in 96 bytes each from kMostMessages on.
class InstanceList {
 public:
  /// Up to so many instances have a message each, which people can read and animations can name.
  static constexpr std::size_t kMostMessages = 4096;

  void add(const std::string& object, const MovingTransform& place);

  /// Names of the objects that are placed, in the order of their first use.
  const std::vector<std::string>& objects() const { return objects_; }

  /// Lets f change the places of those that move.
  template <class F>
  void for_each_moving(F&& f) {
    for (Unpacked& instance : unpacked_) {
      if (instance.place.moves()) f(instance.place);
    }
  }

  /// Writes those whose object `keeps`. Instances that move, and all where they are few, become messages in
  /// the order in which they came; the others follow packed, object by object. The list is empty then.
  /// `Holder` is v1::Scene or v1::Object.
  template <class Holder>
  void move_to(Holder& holder, const std::function<bool(const std::string&)>& keeps, BlobCollector& blobs) {
    write_messages(keeps, *holder.mutable_instances());
    if (std::optional<v1::PackedInstances> packed = pack(keeps, blobs))
      *holder.mutable_packed_instances() = *std::move(packed);
    *this = {};
  }

 private:
  struct Unpacked {
    std::uint32_t object;
    MovingTransform place;
  };

  /// Takes the place into its object's group unless it moves, or is what only a message can hold.
  bool add_packed(std::uint32_t object, const MovingTransform& place);
  void write_messages(const std::function<bool(const std::string&)>& keeps,
                      google::protobuf::RepeatedPtrField<v1::Instance>& messages) const;
  std::optional<v1::PackedInstances> pack(const std::function<bool(const std::string&)>& keeps,
                                          BlobCollector& blobs);

  std::vector<std::string> objects_;
  std::unordered_map<std::string, std::uint32_t> object_numbers_;  // places in objects_
  std::vector<Unpacked> unpacked_;
  bool packs_ = false;
  std::vector<std::vector<double>> groups_by_object_;  // kPackedElements an instance
};

/// Packs the messages of a scene and of its objects where they are many. Those of the world stay where an
/// animation moves some, which it names by their numbers.
void pack_instances(v1::Scene& scene, BlobCollector& blobs);

}  // namespace tessera::client
