// A picture at once: visible surfaces by a z-buffer, lit by lamps with shadow maps and by ambient light. It
// is not physical: no light goes from one surface to another but as a constant.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <stop_token>
#include <string_view>
#include <utility>

#include "render/integrator/integrator.h"
#include "render/textbook/preview/frame.h"
#include "render/textbook/preview/raster.h"
#include "render/transport/vertex/path_state.h"
#include "render/transport/vertex/sample_batch.h"
#include "render/transport/vertex/vertex.h"

namespace tessera::render::TESSERA_ISA {

class Preview final : public Integrator {
 public:
  /// `context.prepared` is a PreviewFrame.
  explicit Preview(const IntegratorContext& context);

  /// Algorithm::prepare.
  static std::unique_ptr<const Prepared> prepare(const SceneTables& scene,
                                                 std::span<const std::string_view> blobs);

  bool render(SampleSource& work, Film& film, std::stop_token stop) override;

 private:
  /// Bin and number of samples.
  using BinName = std::pair<std::uint32_t, std::uint32_t>;

  const BinHits& hits_of(BinName name);
  Hit find(int first);
  void shade(int first);
  void add_background(const WidePath& path, Mask missed);
  Spectrum reflected(const Vertex& v, Int slot, Mask hit) const;

  const SceneTables& scene_;
  const PreviewFrame& frame_;
  const RayQuery& rays_;
  RenderStats& stats_;
  SampleBatch batch_;
  PathState paths_;
  std::unique_ptr<Raster> raster_;
  std::map<BinName, std::unique_ptr<BinHits>> bins_;
  BinName latest_name_{};
  const BinHits* latest_ = nullptr;  // among them
};

}  // namespace tessera::render::TESSERA_ISA
