// The job's settings: which algorithms run, and the AOVs.
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <utility>

#include "absl/strings/str_cat.h"
#include "render/build/scene_builder.h"
#include "wire/job_check.h"
#include "wire/limits.h"

namespace tessera::render {

namespace {

/// Finds the choice called `name`, or the first when `name` is empty. InvalidArgument names them all.
template <class T>
absl::Status choose(const char* what, const std::string& name,
                    std::initializer_list<std::pair<const char*, T>> choices, T& choice) {
  std::string all;
  for (const auto& [own, value] : choices) {
    if (name.empty() || name == own) {
      choice = value;
      return absl::OkStatus();
    }
    absl::StrAppend(&all, all.empty() ? "" : ", ", own);
  }
  return absl::InvalidArgumentError(absl::StrCat(what, " '", name, "' does not exist; there are: ", all));
}

}  // namespace

absl::Status SceneBuilder::build_algorithms() {
  const v1::RenderSettings& settings = job_.settings();
  if (auto s = wire::check_algorithm(job_); !s.ok()) return s;
  algorithm_ = wire::find_algorithm(settings.integrator());
  if (auto s = choose("sampler", settings.sampler(),
                      {{"sobol", SamplerKind::kSobol}, {"independent", SamplerKind::kIndependent}},
                      tables_.sampler.kind);
      !s.ok()) {
    return s;
  }
  if (auto s = choose(
          "intersection", settings.intersection(),
          {{"auto", Intersection::kAuto}, {"fast", Intersection::kFast}, {"robust", Intersection::kRobust}},
          intersection_);
      !s.ok()) {
    return s;
  }
  if (auto s = choose("traversal", settings.traversal(), {{"packet", false}, {"single", true}}, single_rays_);
      !s.ok())
    return s;
  if (auto s = choose("light selection", settings.light_selection(),
                      {{"auto", LightSelection::kAuto},
                       {"tree", LightSelection::kTree},
                       {"mixed", LightSelection::kMixed},
                       {"power", LightSelection::kPower},
                       {"uniform", LightSelection::kUniform}},
                      light_selection_);
      !s.ok()) {
    return s;
  }
  bool by_chance = false;
  if (auto s = choose("direct light", settings.direct_light(), {{"mis", false}, {"bsdf", true}}, by_chance);
      !s.ok())
    return s;
  if (by_chance) light_selection_ = LightSelection::kNone;
  return absl::OkStatus();
}

absl::Status SceneBuilder::build_settings() {
  if (auto s = build_algorithms(); !s.ok()) return s;
  const v1::RenderSettings& settings = job_.settings();
  tables_.sampler.seed = settings.seed();
  tables_.max_depth = static_cast<std::int32_t>(std::min(settings.max_depth(), wire::kMaxDepth));
  for (const std::string& aov : job_.aovs()) {
    if (aov == "albedo") tables_.aovs.albedo = true;
    if (aov == "normal") tables_.aovs.normal = true;
    if (aov == "depth") tables_.aovs.depth = true;
  }
  tables_.exposure = scene_.film().has_exposure() ? scene_.film().exposure() : 1.0f;
  if (!std::isfinite(tables_.exposure)) return absl::InvalidArgumentError("film: the exposure is not finite");
  return absl::OkStatus();
}

}  // namespace tessera::render
