// Data that all threads read which draw one picture: made once, by all of them together.
#pragma once

#include <cstdint>
#include <memory>
#include <stop_token>
#include <vector>

#include "render/film/prepared.h"
#include "render/integrator/scene_tables.h"
#include "render/textbook/preview/bins.h"
#include "render/textbook/preview/clusters.h"
#include "render/textbook/preview/lighting.h"
#include "render/textbook/preview/shadow_map.h"
#include "render/textbook/preview/shared_work.h"

namespace tessera::render::TESSERA_ISA {

class PreviewFrame final : public Prepared {
 public:
  /// Plans the work; `scene` outlives it.
  explicit PreviewFrame(const SceneTables& scene);

  /// Makes what the rest of the interface gives, together with all threads that call this. False when stopped
  /// before the end.
  bool finish(const RayQuery& rays, std::stop_token stop) const { return work_->help(rays, stop); }

  const Clusters& clusters() const { return clusters_; }
  const Lighting& lighting() const { return lighting_; }
  /// Maps of the first lamps; empty without shadows.
  const std::vector<std::unique_ptr<ShadowMap>>& shadows() const { return shadows_; }
  /// The camera's view, with samples at a place in their pixels.
  View view(std::int32_t sample_x, std::int32_t sample_y) const {
    return {scene_.sensor, *eyes_.front().bins, eyes_.front().shape_seen, sample_x, sample_y};
  }

 private:
  /// The camera, or a face of a shadow map.
  struct Eye {
    const SensorRecord* sensor;
    std::unique_ptr<Bins> bins;
    std::vector<std::uint8_t> shape_seen;
    ShadowMap* map;
    std::size_t face;
  };

  void add_shadow_maps();
  void add_eye(const SensorRecord& sensor, int reach, std::int32_t without, ShadowMap* map, std::size_t face);
  std::vector<SharedWork::Stage> stages();
  void draw_row(std::size_t piece, const RayQuery& rays) const;

  const SceneTables& scene_;
  Clusters clusters_;
  const Lighting lighting_;
  std::vector<std::unique_ptr<ShadowMap>> shadows_;
  std::vector<Eye> eyes_;
  std::vector<std::pair<std::size_t, int>> shadow_bin_rows_;  // eye, row
  std::unique_ptr<SharedWork> work_;
};

}  // namespace tessera::render::TESSERA_ISA
