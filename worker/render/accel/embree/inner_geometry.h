// Instances in objects: Debian's Embree has one level of instances, which is the world's. Those below it are
// primitives of a geometry of ours, whose callbacks move rays into the space of an instance and ask the scene
// of its object.
#pragma once

#include <cstdint>
#include <vector>

#include "render/accel/embree/embree.h"

namespace tessera::render {

struct ShapeTable;

/// User pointer of the Embree geometry of all instances in one object.
struct InnerGeometry {
  const ShapeTable* table = nullptr;
  const std::vector<RTCScene>* objects = nullptr;  // scenes of ShapeTable::objects
  std::int32_t first = 0;                          // index in ShapeTable::inner
};

/// Set in the geometry id of a hit in such an instance; the other bits are the shape's. A missed ray has all
/// bits set.
inline constexpr unsigned kInnerHit = 1u << 30;
inline bool is_inner_hit(unsigned geometry) {
  return geometry != RTC_INVALID_GEOMETRY_ID && (geometry & kInnerHit) != 0;
}

}  // namespace tessera::render
