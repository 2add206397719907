// Values of camera rays' first hits for compositors, beyond colour, normal and depth: places, motion, and
// which shape, material and asset it was. There where a job asks for any of them, and no part of a batch
// else.
#pragma once

#include <algorithm>
#include <span>

#include "render/integrator/scene_tables.h"
#include "render/transport/vertex/path_state.h"
#include "render/transport/vertex/vertex.h"

namespace tessera::render::TESSERA_ISA {

/// The rows of the list of AOVs (wire/aov_list.h) that are kept here: from kPosition on.
constexpr std::span<const wire::HitAovRow> first_hit_rows() {
  return std::span(wire::kHitAovs).subspan(static_cast<std::size_t>(wire::HitAov::kPosition));
}

/// The first of the values of row `i` of that list; of the row behind the last, how many there are.
constexpr int first_hit_value(std::size_t i) {
  int count = 0;
  for (const wire::HitAovRow& row : first_hit_rows())
    count += static_cast<std::size_t>(row.aov) < i ? row.channel_count() : 0;
  return count;
}

class FirstHits {
 public:
  explicit FirstHits(const SceneTables& scene) : scene_(scene) {}

  static bool are_wanted(const AovRequest& aovs) {
    return std::ranges::any_of(first_hit_rows(),
                               [&](const wire::HitAovRow& row) { return aovs.has(row.aov); });
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
  static constexpr int kValues = first_hit_value(std::size(wire::kHitAovs));

  /// Keeps an AOV's values.
  template <class... Values>
  void keep(wire::HitAov aov, Int slot, Mask lanes, Values... values) {
    int i = first_hit_value(static_cast<std::size_t>(aov));
    (scatter(values, values_[i++], slot, lanes), ...);
  }
  /// How far what was hit moves over the film while the shutter is open.
  void record_motion(const Hit& found, Int slot, Mask hit);

  const SceneTables& scene_;
  alignas(64) Lanes<float> values_[kValues];  // values, one for each channel; kPosition: in render space
  alignas(64) Lanes<float> time_;
};

}  // namespace tessera::render::TESSERA_ISA
