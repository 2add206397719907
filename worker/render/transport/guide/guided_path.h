// Path tracing that learns where light comes from [Müller, Gross & Novák 2017]: in phases, each of which
// follows twice as many paths as the one before and is guided by all of them. In place of trees, sums are
// kept in cells of fixed size (guide_cell.h), and cells of few samples are merged when they are read.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>

#include "render/transport/guide/guide_steering.h"
#include "render/transport/path/wavefront.h"

namespace tessera::render::TESSERA_ISA {

class GuidedPath : public Wavefront {
 public:
  /// Without a field in the context, it is path tracing.
  explicit GuidedPath(const IntegratorContext& context);

 private:
  std::optional<GuideSteering> guide_;
};

/// Sums of a part of a phase, and of several parts.
bool make_guide(const IntegratorContext& context, const PartRequest& part, std::stop_token stop,
                std::string& blob);
bool merge_guides(std::span<const std::string_view> blobs, std::string& merged);
std::unique_ptr<const Prepared> prepare_guide(const SceneTables& scene,
                                              std::span<const std::string_view> blobs);

}  // namespace tessera::render::TESSERA_ISA
