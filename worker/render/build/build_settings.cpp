// The job's settings: which algorithms run, and the AOVs. They have been checked (wire/job_check.h).
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "render/build/scene_builder.h"
#include "wire/algorithm.h"
#include "wire/limits.h"

namespace tessera::render {

namespace {

LightSelection selection_of(const v1::Algorithms& asked) {
  if (asked.direct_light() == v1::DIRECT_LIGHT_BSDF) return LightSelection::kNone;
  switch (asked.light_selection()) {
    case v1::LIGHT_SELECTION_TREE:
      return LightSelection::kTree;
    case v1::LIGHT_SELECTION_MIXED:
      return LightSelection::kMixed;
    case v1::LIGHT_SELECTION_POWER:
      return LightSelection::kPower;
    case v1::LIGHT_SELECTION_UNIFORM:
      return LightSelection::kUniform;
    default:
      return LightSelection::kAuto;
  }
}

}  // namespace

absl::Status SceneBuilder::build_settings() {
  const v1::Algorithms& asked = job_.content().algorithms();
  algorithm_ = wire::find_algorithm(asked.integrator());
  intersection_ = asked.intersection();
  single_rays_ = asked.traversal() == v1::TRAVERSAL_SINGLE;
  light_selection_ = selection_of(asked);
  const v1::JobSpec::View& view = job_.view();
  tables_.sampler.kind =
      view.sampler() == v1::SAMPLER_INDEPENDENT ? SamplerKind::kIndependent : SamplerKind::kSobol;
  tables_.sampler.seed = view.seed();
  tables_.max_depth = static_cast<std::int32_t>(std::min(view.max_depth(), wire::kMaxDepth));
  for (const int aov : view.aovs()) {
    if (aov == v1::AOV_ALBEDO) tables_.aovs.albedo = true;
    if (aov == v1::AOV_NORMAL) tables_.aovs.normal = true;
    if (aov == v1::AOV_DEPTH) tables_.aovs.depth = true;
  }
  tables_.exposure = scene_.film().has_exposure() ? scene_.film().exposure() : 1.0f;
  if (!std::isfinite(tables_.exposure)) return absl::InvalidArgumentError("film: the exposure is not finite");
  return absl::OkStatus();
}

}  // namespace tessera::render
