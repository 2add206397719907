#include "measure/placed_things.h"

#include <ImathMatrix.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "import/geometry/transform.h"

namespace tessera::client {

namespace {

/// Surfaces that instances may place: each takes probes of both sides, with some thousand paths.
constexpr std::size_t kMostPlacedShapes = 4096;
/// Bytes of the meshes that they may have: workers hold the triangles of each place apart.
constexpr std::uint64_t kMostMeshBytes = std::uint64_t{1} << 27;

class ThingList {
 public:
  explicit ThingList(const v1::Scene& scene) : scene_(scene) {
    for (const v1::Object& object : scene.objects()) objects_.emplace(object.name(), &object);
    for (const v1::Material& material : scene.materials())
      if (material.has_interface()) passed_.insert(material.name());
    for (const v1::Instance& instance : scene.instances()) ++instances_of_[instance.object()];
  }

  std::vector<PlacedThing> list() {
    for (int i = 0; i < scene_.shapes_size(); ++i) {
      PlacedThing& thing = things_.emplace_back();
      thing.name = scene_.shapes(i).name();
      if (thing.name.empty()) thing.name = absl::StrCat("shape ", i + 1);
      add(scene_.shapes(i), thing);
    }
    for (const v1::Instance& instance : scene_.instances()) add_instance(instance);
    for (const v1::PackedInstances::Run& run : scene_.packed_instances().runs()) {
      PlacedThing& thing = things_.emplace_back();
      thing.name = absl::StrCat("instances of ", run.object());
      thing.shines = shines(run.object());
      thing.obstacle = absl::StrCat("there are ", run.count(), " of them");
    }
    std::erase_if(things_,
                  [](const PlacedThing& thing) { return thing.shapes.empty() && thing.obstacle.empty(); });
    return std::move(things_);
  }

 private:
  void add(const v1::Shape& shape, PlacedThing& thing) const {
    if (passed_.contains(shape.material()) && !shape.has_area_light()) return;
    thing.shapes.push_back(shape);
    thing.shines |= shape.has_area_light();
  }

  void add_instance(const v1::Instance& instance) {
    PlacedThing& thing = things_.emplace_back();
    thing.name = instance.object();
    if (instances_of_[instance.object()] > 1)
      absl::StrAppend(&thing.name, " ", ++numbers_of_[instance.object()]);
    const std::uint64_t bytes = mesh_bytes_;
    add(instance, Imath::M44d(), thing);
    shapes_ += thing.shapes.size();
    thing.shines = shines(instance.object());
    if (thing.obstacle.empty()) return;
    shapes_ -= thing.shapes.size(), mesh_bytes_ = bytes;
    thing.shapes.clear();
  }

  void add(const v1::Instance& instance, const Imath::M44d& outer, PlacedThing& thing) {
    if (instance.has_world_from_instance_end() || instance.motion_size() > 0) thing.obstacle = "it moves";
    const auto found = objects_.find(instance.object());
    if (found == objects_.end()) thing.obstacle = "its object is not there";
    if (!thing.obstacle.empty()) return;
    const v1::Object& object = *found->second;
    const Imath::M44d world_from_object = matrix_of(instance.world_from_instance()) * outer;
    for (const v1::Shape& shape : object.shapes()) {
      const std::size_t before = thing.shapes.size();
      add(shape, thing);
      if (thing.shapes.size() == before) continue;
      write_matrix(matrix_of(shape.world_from_object()) * world_from_object,
                   *thing.shapes.back().mutable_world_from_object());
      mesh_bytes_ += shape.mesh().blob().size_bytes();
      if (shapes_ + thing.shapes.size() > kMostPlacedShapes || mesh_bytes_ > kMostMeshBytes)
        thing.obstacle = "instances hold too many surfaces for it to be read, too";
      if (!thing.obstacle.empty()) return;
    }
    if (object.has_packed_instances()) thing.obstacle = "it holds packed instances";
    for (const v1::Instance& inner : object.instances()) {
      if (!thing.obstacle.empty()) return;
      add(inner, world_from_object, thing);
    }
  }

  /// Whether an object, or one that it holds, has light of its own.
  bool shines(const std::string& name) {
    const auto known = shines_.find(name);
    if (known != shines_.end()) return known->second;
    bool& shines_now = shines_[name];
    const auto found = objects_.find(name);
    if (found == objects_.end()) return false;
    bool any = false;
    for (const v1::Shape& shape : found->second->shapes()) any |= shape.has_area_light();
    for (const v1::Instance& inner : found->second->instances()) any |= shines(inner.object());
    for (const auto& run : found->second->packed_instances().runs()) any |= shines(run.object());
    return shines_now = any;
  }

  const v1::Scene& scene_;
  std::map<std::string, const v1::Object*> objects_;
  std::set<std::string> passed_;  // names of materials without a surface
  std::map<std::string, std::size_t> instances_of_, numbers_of_;
  std::map<std::string, bool> shines_;
  std::size_t shapes_ = 0;  // of instances
  std::uint64_t mesh_bytes_ = 0;
  std::vector<PlacedThing> things_;
};

}  // namespace

std::vector<PlacedThing> placed_things(const v1::Scene& scene) { return ThingList(scene).list(); }

}  // namespace tessera::client
