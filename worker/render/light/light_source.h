// Properties of lights by which one is chosen: the part of a light's model that is asked when a scene
// is built. The models (light.h) have it too.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "render/core/vec64.h"
#include "render/light/light_table.h"

namespace tessera::render {

/// Properties of a model that hold whatever its parameters are.
struct LightTraits {
  bool at_infinity = false;               // it has no bounds, and its power is what falls on the scene
  bool delta = false;                     // Only light sampling and emission find it.
  bool extended = false;                  // a delta light with many points, which are chosen with a density
  bool uses_normals = false;              // sampling and its density look at Receiver::normal
  ShapeKind surface = ShapeKind::kCount;  // it is what shapes of this kind emit; kCount: it is on none
};

/// Where a light is, where it shines, and how brightly [Conty Estevez & Kulla 2018].
struct LightBounds {
  vec64::Vec low = {INFINITY, INFINITY, INFINITY}, high = {-INFINITY, -INFINITY, -INFINITY};
  vec64::Vec axis = {0, 0, 1};  // axis of a cone that holds its normals
  double angle = 0;             // half of that cone's opening angle
  double reach = 0;             // angle off a normal up to which a light shines
  double intensity = 0;         // along a normal; mean of R, G and B
  bool two_sided = false;

  void add(const vec64::Vec& p) {
    for (std::size_t c = 0; c < 3; ++c) {
      low[c] = std::min(low[c], p[c]);
      high[c] = std::max(high[c], p[c]);
    }
  }
};

class LightSource {
 public:
  explicit constexpr LightSource(LightTraits model_traits) : traits(model_traits) {}
  virtual ~LightSource() = default;

  const LightTraits traits;

  /// Emitted power in watts, mean of R, G and B; of lights at infinity what falls on a disk of the scene's
  /// radius.
  virtual double power(const LightTable& table, const LightRecord& light) const = 0;
  /// Not asked of lights at infinity.
  virtual LightBounds bounds(const LightTable& table, const LightRecord& light) const = 0;
  /// R, G and B of the flux in watts that light `light` of the table emits when the shutter opens, textures
  /// and all: the mean of so many rays, the same for the same table. Not asked of lights at infinity.
  virtual std::array<double, kBands> emitted_flux(const LightTable& table, std::int32_t light,
                                                  std::int32_t rays) const {
    return {};
  }
  /// Appends the lights of a shape of the kind traits.surface. `light` has what all of them share.
  virtual void append(const ShapeTable& shapes, const ShapeRecord& shape, const LightRecord& light,
                      float interpolated_pick, std::vector<LightRecord>& lights) const {}
};

/// Mean of R, G and B of the record's radiance, intensity or irradiance.
inline double mean_radiance(const LightRecord& light) {
  return (double{light.radiance[0]} + light.radiance[1] + light.radiance[2]) / 3;
}
/// Area of a disk that covers the scene.
inline double scene_disk(const LightTable& table) {
  return std::numbers::pi * table.scene_radius * table.scene_radius;
}

}  // namespace tessera::render
