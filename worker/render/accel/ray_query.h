// The questions that rays ask of a scene's geometry, whatever structure answers them.
#pragma once

#include <cstdint>

namespace tessera::render {

/// Arrays of at least `n` rays, rounded up to 16; aligned to 64 bytes. Directions have unit length.
struct RayArrays {
  const float *ox, *oy, *oz, *dx, *dy, *dz;
  const float* time = nullptr;  // 0 (the shutter opens) to 1; null: 0 for all
};

/// `shape` is -1 on a miss, and the rest then undefined. `instance` is -1 outside instances, else its number
/// counted from 0; in scenes with objects within objects, that of the place (shape/place.h). `t` is infinite
/// on a miss.
struct HitArrays {
  float *t, *u, *v;
  std::int32_t *primitive, *shape, *instance;
  // Counts of what each search opened and tested, where somebody asks and the query counts.
  std::int32_t *visited_nodes = nullptr, *visited_primitives = nullptr;
  std::int32_t* upper = nullptr;  // bits of the place from the 31st on; left alone in all other scenes
};

/// Counts of what searches have opened and tested.
struct RayVisits {
  std::uint64_t nodes = 0, primitives = 0;

  RayVisits& operator+=(const RayVisits& other) {
    nodes += other.nodes, primitives += other.primitives;
    return *this;
  }
  RayVisits operator-(const RayVisits& other) const {
    return {nodes - other.nodes, primitives - other.primitives};
  }
};

/// Shapes and instances are numbered as in ShapeTable. Safe to use from any number of threads at once.
class RayQuery {
 public:
  virtual ~RayQuery() = default;

  /// Nearest hits along the rays. Rays that are not finite, or have coordinates beyond 1.8e18, meet nothing.
  /// `coherent`: neighbours have nearly the same origin and direction, as camera rays do.
  virtual void nearest(const RayArrays& rays, int n, bool coherent, const HitArrays& hits) const = 0;

  /// Sets blocked[i] to a negative number where something lies within `distance` along the ray, else leaves
  /// the distance. Rays that are not finite are blocked.
  virtual void occluded(const RayArrays& rays, int n, float* distance_in_blocked_out) const = 0;

  /// Visits of all rays so far; none where the query does not count.
  virtual RayVisits visits() const { return {}; }
};

}  // namespace tessera::render
