// Shadow maps [Williams 1978]: the scene as a lamp sees it, with hard shadows, filtered ones [Reeves et al.
// 1987], and ones as soft as the lamp is large [Fernando 2005].
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "render/integrator/integrator_settings.h"
#include "render/textbook/preview/bins.h"
#include "render/textbook/preview/lighting.h"
#include "render/textbook/preview/raster.h"

namespace tessera::render::TESSERA_ISA {

/// Texels along a side of a face.
inline constexpr int kFaceSide = 512;
/// Those of the one face of a lamp that is far away or has a narrow cone.
inline constexpr int kOnlyFaceSide = 1024;

/// Where 16 points of surfaces are.
struct ShadowReceiver {
  Vec3 p, n;        // n: geometric normal
  Float tap_angle;  // turns the pattern of taps
};

class ShadowMap {
 public:
  ShadowMap(const SceneTables& scene, const Lamp& lamp);

  /// Views of the scene that its texels come from.
  std::size_t faces() const { return faces_.size(); }
  const SensorRecord& sensor(std::size_t face) const { return faces_[face].sensor; }
  int side() const { return side_; }
  /// Takes over a bin of a face.
  void put(std::size_t face, int column, int row, const float* nearness);

  /// The share of the lamp that is seen from the receivers.
  Float visible(const ShadowReceiver& at, ShadowKind kind, Mask active) const;

 private:
  struct Face {
    int number;  // axis * 2, and 1 more for the one against it
    SensorRecord sensor;
  };
  /// A receiver in the map's own space: from the lamp, in its frame.
  struct Local {
    Vec3 v, n;          // n on the lamp's side
    Float lamp_height;  // over the receiver's plane
    Float position_rounding;
    Vec3 across_u, across_v;  // across the way to the lamp
  };
  struct Tap {
    Mask blocked;
    Float texel_depth;
  };

  void add_face(int number, float half_tangent);
  Local localise(const ShadowReceiver& at) const;
  Tap tap(const Local& at, Vec3 v, Mask active) const;
  Tap tap_face(const Local& at, Vec3 v, Mask active) const;
  Tap tap_parallel(const Local& at, Vec3 v, Mask active) const;
  Vec3 tap_place(const Local& at, int tap, Float radius, Float cosine, Float sine) const;
  Float depth_of(const Local& at) const;

  const Lamp& lamp_;
  float frame_[3][3];  // rows: the map's axes in render space, the last along the light
  float depth_origin_[3];
  float reach_;  // half of the side of a parallel map; the tangent of half of a face's angle otherwise
  int side_;
  std::vector<Face> faces_;
  std::vector<float> texels_;  // nearness (bins.h), rows of all six faces, or of the only one
};

}  // namespace tessera::render::TESSERA_ISA
