#include "scheduler/phase_plan.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "base/split_mix.h"
#include "wire/limits.h"

namespace tessera::server {

std::uint64_t inputs_key(const std::vector<ResultFingerprint>& inputs) {
  std::uint64_t key = 0;
  for (const ResultFingerprint input : inputs) key = base::split_mix(key + input);
  return key;
}

absl::StatusOr<PhasePlan> PhasePlan::make(const v1::JobSpec& spec) {
  PhasePlan plan;
  if (spec.cut().phases_size() > wire::kMaxPhases) {
    return absl::InvalidArgumentError(absl::StrCat("job: it has ", spec.cut().phases_size(),
                                                   " phases; at most ", wire::kMaxPhases, " were expected"));
  }
  for (int p = 0; p < spec.cut().phases_size(); ++p) {
    const v1::Phase& phase = spec.cut().phases(p);
    if (phase.parts() == 0 || phase.parts() > wire::kMaxPartsPerPhase || phase.merge_width() < 2 ||
        phase.merge_width() > wire::kMaxMergeWidth) {
      return absl::InvalidArgumentError(
          absl::StrCat("job: phase \"", phase.name().substr(0, wire::kMaxTextBytes), "\" has ", phase.parts(),
                       " parts and merge_width ", phase.merge_width(), "; 1 to ", wire::kMaxPartsPerPhase,
                       " and 2 to ", wire::kMaxMergeWidth, " were expected"));
    }
    Step step{.first = plan.unit_count_,
              .count = phase.parts(),
              .phase = static_cast<std::uint32_t>(p),
              .level = 0,
              .merge_width = phase.merge_width()};
    plan.steps_.push_back(step);
    while (step.count > 1) {
      step.first = step.end();
      step.count = (step.count + step.merge_width - 1) / step.merge_width;
      ++step.level;
      plan.steps_.push_back(step);
    }
    plan.unit_count_ = step.end();
    plan.roots_.push_back(step.first);
  }
  return plan;
}

const PhasePlan::Step* PhasePlan::step_of(std::uint32_t unit) const {
  if (unit >= unit_count_) return nullptr;
  const auto after = std::upper_bound(steps_.begin(), steps_.end(), unit,
                                      [](std::uint32_t u, const Step& step) { return u < step.first; });
  return &*std::prev(after);
}

v1::WorkUnit PhasePlan::unit(std::uint32_t index) const {
  const Step& step = *step_of(index);
  v1::WorkUnit unit;
  unit.set_index(index);
  if (step.level == 0) {
    unit.mutable_part()->set_phase(step.phase);
    unit.mutable_part()->set_part(index - step.first);
  } else {
    unit.mutable_merge()->set_phase(step.phase);
    unit.mutable_merge()->set_level(step.level);
    unit.mutable_merge()->set_index(index - step.first);
  }
  return unit;
}

std::uint32_t PhasePlan::step_end(std::uint32_t first) const { return step_of(first)->end(); }

std::uint32_t PhasePlan::step_begin(std::uint32_t unit) const {
  const Step* const step = step_of(unit);
  return step == nullptr ? unit_count_ : step->first;
}

std::vector<std::uint32_t> PhasePlan::inputs(std::uint32_t unit) const {
  const Step* const step = step_of(unit);
  if (step == nullptr) return roots_;
  if (step->level == 0) return {roots_.begin(), roots_.begin() + step->phase};
  // The level before is the step before.
  const Step& below = *(step - 1);
  const std::uint32_t begin = below.first + (unit - step->first) * step->merge_width;
  std::vector<std::uint32_t> children;
  for (std::uint32_t child = begin; child < std::min(begin + step->merge_width, below.end()); ++child)
    children.push_back(child);
  return children;
}

std::vector<std::uint32_t> PhasePlan::sources(std::uint32_t unit) const {
  std::vector<std::uint32_t> found;
  const Step* const step = step_of(unit);
  const std::uint32_t own_phase = step == nullptr ? static_cast<std::uint32_t>(roots_.size()) : step->phase;
  // All of the phases before, whose blobs are in every part of this one.
  const std::uint32_t before = own_phase == 0 ? 0 : roots_[own_phase - 1] + 1;
  for (std::uint32_t source = 0; source < before; ++source) found.push_back(source);
  // A merge has also the units of its own phase that it merges, level by level.
  if (step == nullptr || step->level == 0) return found;
  std::vector<std::uint32_t> level = inputs(unit);
  while (!level.empty()) {
    found.insert(found.end(), level.begin(), level.end());
    if (step_of(level.front())->level == 0) break;
    std::vector<std::uint32_t> below;
    for (const std::uint32_t source : level) {
      const std::vector<std::uint32_t> children = inputs(source);
      below.insert(below.end(), children.begin(), children.end());
    }
    level = std::move(below);
  }
  std::sort(found.begin(), found.end());
  return found;
}

std::optional<std::uint32_t> PhasePlan::reader(std::uint32_t unit) const {
  const Step* const step = step_of(unit);
  if (step == nullptr || step->count == 1) return std::nullopt;
  return step->end() + (unit - step->first) / step->merge_width;
}

std::optional<std::uint32_t> PhasePlan::phase_of(std::uint32_t unit) const {
  const Step* const step = step_of(unit);
  return step == nullptr ? std::nullopt : std::optional(step->phase);
}

std::uint32_t PhasePlan::phase_end(std::uint32_t unit) const {
  return *std::lower_bound(roots_.begin(), roots_.end(), unit) + 1;
}

}  // namespace tessera::server
