// Where shapes stand: in the world, in objects that instances place, and on their way while the shutter is
// open. A shape that moves is an object of its own, placed by a moving instance; of many meshes that move,
// those that few steps follow have vertices of several keys instead. An emitting shape of an object is an
// object of its own, too, once for each of its places in the world.
#pragma once

#include <functional>
#include <span>
#include <stop_token>
#include <string>
#include <unordered_set>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "render/scene/blob_source.h"
#include "render/scene/placement/motion.h"
#include "render/scene/placement/render_space.h"
#include "render/scene/shape/object_part.h"
#include "render/scene/shape/shape_builder.h"
#include "render/scene/values/name_table.h"
#include "render/shape/shape_table.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::render {

class InstanceBuilder {
 public:
  using Shapes = google::protobuf::RepeatedPtrField<v1::Shape>;

  /// Has `shapes`, which fills the same table, build each shape.
  InstanceBuilder(const RenderSpace& space, const BlobSource& blobs, ShapeBuilder& shapes, ShapeTable& table,
                  std::vector<std::string>& warnings, std::stop_token stop = {})
      : space_(space),
        blobs_(blobs),
        shapes_(shapes),
        table_(table),
        warnings_(warnings),
        stop_(std::move(stop)) {}

  /// All shapes of the scene's world, objects and instances, which fill the table; it outlives the builder.
  /// InvalidArgument names the element. `asked` and `wants_flat`: plan_nesting(). Throws Stopped once a stop
  /// is requested.
  absl::Status build(const v1::Scene& scene, v1::Nesting asked = v1::NESTING_UNSPECIFIED,
                     const std::string& wants_flat = "");

  /// Note on what was made of objects within objects, and why; empty where there are none.
  const std::string& note() const { return note_; }

  /// InvalidArgument, naming the instance, where rays from within a sphere of render space leave floats'
  /// range in an instance's own space.
  absl::Status check_reach(const float* centre, float radius) const;

 private:
  using ObjectParts = std::vector<ObjectPart>;
  /// Where records of instances go, and what maps their holder's space to that of the records.
  struct Holder {
    Transform from_space;
    std::vector<InstanceRecord>& records;
  };

  /// The instances of the scene, or of one of its objects: messages, then packed ones.
  struct Written {
    const google::protobuf::RepeatedPtrField<v1::Instance>* messages = nullptr;
    BlobBytes blob;
    std::span<const double> packed;  // points into the blob

    std::size_t size() const;
    absl::StatusOr<Motion> motion(std::size_t i) const;
  };
  template <class Message>
  absl::StatusOr<Written> read_instances(const Message& holder) const;
  /// Fills written_world_ and written_objects_.
  absl::Status read_all_instances();

  /// Sets whether meshes that move are to have keys.
  absl::Status count_moving_meshes(const Shapes& shapes);
  /// Whether a part has to stand in the world by itself: one without end must not count for the size of a
  /// group, and light is emitted at one place.
  bool stands_alone(const ObjectPart& part) const;
  /// The same part for one more place in the world, if it emits light.
  absl::Status own_emitter(ObjectPart& part);
  /// Lights have places of 32 bits: those of groups may be larger, and so they come behind.
  void move_lamps_forward();
  /// The shapes that do not move, and do not stand alone; gives the places of the others.
  absl::StatusOr<std::vector<int>> add_still(const Shapes& shapes, const Transform& placed_from_shapes,
                                             const std::function<std::string(int)>& where, bool instanced);
  /// A part without an object where there is nothing of it to be seen.
  absl::StatusOr<ObjectPart> build_moving_shape(const v1::Shape& shape, std::int32_t number, bool instanced,
                                                const std::string& where);
  /// Builds a shape; its records have the scene's `number`.
  absl::Status add_shape(const v1::Shape& shape, const Transform& placed_from_object, std::int32_t number,
                         bool instanced, const std::string& where,
                         std::span<const Transform> later_places = {});
  /// Warns of a motion that its steps do not follow closely.
  void warn_of_roughness(const MotionSteps& steps, const std::string& where);
  absl::Status add_moving(const Shapes& shapes, const std::vector<int>& moving);
  absl::StatusOr<ObjectParts> build_object(const v1::Object& object);
  /// A point among the shapes where they are all far from the origin of instance space, else that origin:
  /// floats hold coordinates about the one as well as those about the other if the author had put it there.
  absl::StatusOr<Imath::V3d> anchor_of(const v1::Object& object) const;
  /// Adds to an object's parts what its instances place; of one that is `kept`, as a group of ShapeTable.
  absl::Status add_held(int object, const std::vector<int>& held, bool kept);
  /// Calls f(i, part) for the parts of objects[i] where instance i places them, which is then done with; a
  /// singular one is left out. Messages of errors begin with `where`.
  template <class F>
  absl::Status for_each_placed(const Written& instances, const std::vector<int>& objects,
                               const std::string& where, F&& f);
  /// Where the holder of instances that stand together, far from its origin, has them; else that origin.
  static absl::StatusOr<Imath::V3d> anchor_of_group(const Written& instances);
  /// In the world, or `kept` in one object that stands there, but for what has no end.
  absl::Status add_world_instances(bool kept);
  absl::Status add_instance(const ObjectPart& part, const Holder& holder);
  /// Name of the instance with this index in ShapeTable::instances, for messages.
  std::string name_of_instance(std::size_t index) const;

  const RenderSpace& space_;
  const BlobSource& blobs_;
  ShapeBuilder& shapes_;
  ShapeTable& table_;
  std::vector<std::string>& warnings_;
  const std::stop_token stop_;
  NameTable object_names_{"object"};
  const v1::Scene* scene_ = nullptr;
  Written written_world_;
  std::vector<Written> written_objects_;
  bool meshes_have_keys_ = false;  // those of the world that move and whose motion few steps follow
  std::vector<int> placed_;        // the object of each of the world's instances
  std::vector<ObjectParts> object_parts_;
  std::vector<std::uint64_t> uses_;        // instances of each that are still to be built
  std::vector<std::string> moving_names_;  // shapes of the world: the first of ShapeTable::instances
  struct Group {
    std::size_t object = 0;  // in ShapeTable::objects
    std::string name;        // place in the scene
  };
  std::unordered_set<std::int32_t> lamps_;  // those of ShapeTable::objects that are one place of a light
  std::vector<Group> groups_;               // objects that hold others, each behind those
  std::string note_;
  std::int32_t shapes_before_ = 0;  // shapes of the scene before those that are being built
};

}  // namespace tessera::render
