// Ways of lights while the shutter is open.
#pragma once

#include <cstdint>

#include "absl/status/statusor.h"
#include "render/scene/placement/motion.h"
#include "render/shape/shape_table.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::render {

// From a space in which the light stands at the origin, and as when the shutter opens, to the world. They
// stand still where messages have no end. InvalidArgument where a direction is none.
absl::StatusOr<Motion> motion_of_point(const v1::PointLight& light);
absl::StatusOr<Motion> motion_of_spot(const v1::SpotLight& light);
/// The motion turns directions alone.
absl::StatusOr<Motion> motion_of_distant(const v1::DistantLight& light);
/// The motion turns the directions of the map alone. InvalidArgument for maps that change angles, and with a
/// portal.
absl::StatusOr<Motion> motion_of_sky(const v1::InfiniteLight& light);

/// The instance that places a shape of the world that moves; null for other shapes.
const InstanceRecord* place_of_moving_shape(std::int32_t shape, const ShapeTable& shapes);

}  // namespace tessera::render
