// The phases that make the cache: parts of the film, each by itself, and then again what they have left.
#pragma once

#include "render/integrator/integrator.h"

namespace tessera::render::TESSERA_ISA {

/// Makes records wherever paths from the part's pixels come to a surface that none reaches. The first phase
/// looks at few pixels, so that what it makes is spread widely; the second, with all that at hand, at every
/// pixel.
bool make_records(const IntegratorContext& context, const PartRequest& part, std::stop_token stop,
                  std::string& blob);

/// Their records one after the other: the same in whatever groups neighbours are merged.
bool merge_records(std::span<const std::string_view> blobs, std::string& merged);

std::unique_ptr<const Prepared> prepare_records(const SceneTables& scene,
                                                std::span<const std::string_view> blobs);

}  // namespace tessera::render::TESSERA_ISA
