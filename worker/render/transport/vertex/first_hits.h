// Values of camera rays' first hits for compositors, beyond colour, normal and depth: places, motion, and
// which shape, material and asset it was. There where a job asks for any of them, and no part of a batch
// else.
#pragma once

#include "render/integrator/scene_tables.h"
#include "render/transport/vertex/path_state.h"
#include "render/transport/vertex/vertex.h"

namespace tessera::render::TESSERA_ISA {

class FirstHits {
 public:
  explicit FirstHits(const SceneTables& scene) : scene_(scene) {}

  static bool are_wanted(const AovRequest& aovs) {
    return aovs.position || aovs.camera_normal || aovs.uv || aovs.motion || aovs.material_id ||
           aovs.crypto_object || aovs.crypto_material || aovs.crypto_asset;
  }
  /// Planes that put() fills.
  std::size_t planes() const;

  /// Empties the entries of 16 samples from `slot` on.
  void clear(int slot);
  /// SampleBatch::record_first_hit().
  void record(const Vertex& v, Int slot, Mask hit);
  /// SampleBatch::record_hit(), after that of the same samples. `shape` and `instance` are the numbers that
  /// they have in the scene, 0 for none.
  void record_hit(const Hit& found, Float shape, Float instance, Int slot, Mask hit);

  /// Puts the channels of 16 samples from `slot` on, in the order of wire::channels_of(), `stride` floats
  /// apart; returns where the next one goes. `covered`: samples that hit something; `weight`: of the filter.
  float* put(int slot, Float weight, Mask covered, float* to, std::size_t stride) const;

 private:
  /// How far what was hit moves over the film while the shutter is open.
  void record_motion(const Hit& found, Int slot, Mask hit);

  const SceneTables& scene_;
  Vec3Lanes position_, camera_normal_;  // render space; camera space
  alignas(64) Lanes<float> u_, v_, motion_u_, motion_v_, time_, shape_, material_, asset_;
};

}  // namespace tessera::render::TESSERA_ISA
