// Where shapes stand: in the world, in objects that instances place, and on their way while the shutter is
// open. A shape that moves is an object of its own, placed by a moving instance.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "render/build/blob_source.h"
#include "render/build/placement/motion.h"
#include "render/build/placement/render_space.h"
#include "render/build/shape/shape_builder.h"
#include "render/build/values/name_table.h"
#include "render/shape/shape_table.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::render {

class InstanceBuilder {
 public:
  using Shapes = google::protobuf::RepeatedPtrField<v1::Shape>;
  using Objects = google::protobuf::RepeatedPtrField<v1::Object>;
  using Instances = google::protobuf::RepeatedPtrField<v1::Instance>;

  /// Has `shapes`, which fills the same table, build each shape.
  InstanceBuilder(const RenderSpace& space, const BlobSource& blobs, ShapeBuilder& shapes, ShapeTable& table,
                  std::vector<std::string>& warnings)
      : space_(space), blobs_(blobs), shapes_(shapes), table_(table), warnings_(warnings) {}

  /// All shapes of the world, objects and instances, which fill the table. InvalidArgument names the element.
  absl::Status build(const Shapes& shapes, const Objects& objects, const Instances& instances);

  /// InvalidArgument, naming the instance, where rays from within a sphere of render space leave floats'
  /// range in an instance's own space.
  absl::Status check_reach(const float* centre, float radius) const;

 private:
  struct MovingShape {
    int object;  // in ShapeTable::objects; -1: there is nothing of it to be seen
    Motion motion;
  };
  struct ObjectParts {
    int still =
        -1;  // in ShapeTable::objects: all shapes that do not move within the object; -1: there are none
    std::vector<MovingShape> moving;
    Imath::V3d anchor{0, 0, 0};  // instance space; `still` is relative to it
  };

  /// Whether `shape` is placed by a moving instance. Of a lamp, warns that it stands still.
  absl::StatusOr<bool> moves(const v1::Shape& shape, bool instanced, const std::string& where);
  /// The shapes that do not move; gives the places of those that do.
  absl::StatusOr<std::vector<int>> add_still(const Shapes& shapes, const Transform& placed_from_shapes,
                                             const std::function<std::string(int)>& where, bool instanced);
  absl::StatusOr<MovingShape> build_moving_shape(const v1::Shape& shape, std::int32_t number, bool instanced,
                                                 const std::string& where);
  /// Builds a shape; its records have the scene's `number`.
  absl::Status add_shape(const v1::Shape& shape, const Transform& placed_from_object, std::int32_t number,
                         bool instanced, const std::string& where);
  absl::Status add_moving(const Shapes& shapes, const std::vector<int>& moving);
  absl::StatusOr<ObjectParts> build_object(const v1::Object& object);
  /// A point among the shapes where they are all far from the origin of instance space, else that origin:
  /// floats hold coordinates about the one as well as those about the other if the author had put it there.
  absl::StatusOr<Imath::V3d> anchor_of(const v1::Object& object) const;
  absl::Status build_instance(const v1::Instance& instance, const ObjectParts& parts,
                              const std::string& where);
  absl::Status add_instance(int object, int segments,
                            const std::function<Transform(double)>& world_from_instance);

  const RenderSpace& space_;
  const BlobSource& blobs_;
  ShapeBuilder& shapes_;
  ShapeTable& table_;
  std::vector<std::string>& warnings_;
  NameTable object_names_{"object"};
  std::vector<ObjectParts> objects_;
  std::vector<std::string> instance_names_;  // of ShapeTable::instances, for messages
  std::int32_t shapes_before_ = 0;           // shapes of the scene before those that are being built
};

}  // namespace tessera::render
