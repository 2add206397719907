// Ways of lights while the shutter is open.
#pragma once

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "render/scene/placement/motion.h"
#include "render/shape/shape_table.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::render {

/// The way of a light from its own space to the world.
struct LightWay {
  /// What a light does of what the motion does with its space.
  enum class Follows {
    kAll,    // it is stretched, too
    kRigid,  // it turns and shifts
    kTurns,  // its directions turn
  };
  Motion motion{Transform{}};
  Follows follows = Follows::kAll;

  bool moves() const { return motion.moves(); }
  Transform at(double time) const;
};

using MotionKeys = Motion::Messages;

// From a space in which the light stands at the origin, and as when the shutter opens, to the world. They
// stand still where messages have neither an end nor keys. InvalidArgument where a direction is none, where
// both are there, and with the errors of Motion; keys of lights without a matrix, and of skies, keep the
// angles between directions.
absl::StatusOr<LightWay> way_of_point(const v1::PointLight& light, const MotionKeys& keys);
absl::StatusOr<LightWay> way_of_spot(const v1::SpotLight& light, const MotionKeys& keys);
/// The motion turns directions alone.
absl::StatusOr<LightWay> way_of_distant(const v1::DistantLight& light, const MotionKeys& keys);
/// The motion turns the directions of the map alone. InvalidArgument with a portal, too.
absl::StatusOr<LightWay> way_of_sky(const v1::InfiniteLight& light, const MotionKeys& keys);

/// Numbers of the instances that place shapes alone, by shape; -1 where no instance does, so that a shape
/// that emits light stands in the world.
std::vector<std::int32_t> instances_by_shape(const ShapeTable& shapes);

}  // namespace tessera::render
