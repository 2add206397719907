#include "wire/job_check.h"

#include <algorithm>
#include <string_view>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "wire/algorithm.h"
#include "wire/limits.h"

namespace tessera::wire {

namespace {

/// AOVs of what a camera ray meets first.
bool is_first_hit_aov(std::string_view aov) { return aov == "albedo" || aov == "normal" || aov == "depth"; }

}  // namespace

absl::Status check_algorithm(const v1::JobSpec& spec) {
  const v1::RenderSettings& settings = spec.settings();
  if (auto s = check_algorithm_name(settings.integrator()); !s.ok()) return s;
  const AlgorithmTraits* const algorithm = find_algorithm(settings.integrator());
  const auto cannot = [&](const char* why) {
    return absl::InvalidArgumentError(absl::StrCat("integrator '", algorithm->name, "' ", why));
  };
  if (settings.noise() != 0 && !algorithm->noise)
    return cannot("takes the same samples everywhere: noise is not for it");
  if (!algorithm->bsdf_lighting && settings.direct_light() == "bsdf") {
    return cannot("has its own way to find direct light: 'bsdf' is not for it");
  }
  if (!algorithm->first_hit_aovs) {
    for (const std::string& aov : spec.aovs()) {
      if (is_first_hit_aov(aov)) return cannot("gives no albedo, normal or depth");
    }
  }
  const auto has_name = [](const v1::Phase& phase, const PhaseTraits& own) {
    return phase.name() == own.name;
  };
  if (!std::equal(spec.phases().begin(), spec.phases().end(), algorithm->phases.begin(),
                  algorithm->phases.end(), has_name)) {
    return cannot(
        absl::StrCat("has other phases than the job: ",
                     absl::StrJoin(algorithm->phases, ", ",
                                   [](std::string* out, const PhaseTraits& p) { out->append(p.name); }))
            .c_str());
  }
  return absl::OkStatus();
}

void add_phases(v1::JobSpec& spec) {
  spec.clear_phases();
  for (const PhaseTraits& own : find_algorithm(spec.settings().integrator())->phases) {
    v1::Phase& phase = *spec.add_phases();
    phase.set_name(own.name);
    phase.set_parts(own.parts);
    phase.set_merge_width(own.merge_width);
  }
}

bool works_in_passes(const v1::JobSpec& spec) {
  const AlgorithmTraits* const algorithm = find_algorithm(spec.settings().integrator());
  return algorithm != nullptr && algorithm->work == WorkKind::kPasses;
}

absl::Status check_noise(const v1::JobSpec& spec) {
  const double noise = spec.settings().noise();
  if (noise == 0) return absl::OkStatus();
  if (!(noise >= kMinNoise && noise <= kMaxNoise)) {
    return absl::InvalidArgumentError(
        absl::StrCat("settings.noise is ", noise, "; 0 or ", kMinNoise, " to ", kMaxNoise, " was expected"));
  }
  if (spec.settings().spp() < kMinAdaptiveSamples) {
    return absl::InvalidArgumentError(absl::StrCat("settings.spp is ", spec.settings().spp(),
                                                   "; with settings.noise it is the cap, and ",
                                                   kMinAdaptiveSamples, " or more was expected"));
  }
  if (spec.tile_size() % kNoiseBlock != 0) {
    return absl::InvalidArgumentError(absl::StrCat("tile_size is ", spec.tile_size(),
                                                   "; with settings.noise a multiple of ", kNoiseBlock,
                                                   " was expected"));
  }
  if (spec.samples_per_unit() < spec.settings().spp()) {
    return absl::InvalidArgumentError(absl::StrCat("samples_per_unit is ", spec.samples_per_unit(),
                                                   "; with settings.noise a unit takes all ",
                                                   spec.settings().spp(), " samples"));
  }
  return absl::OkStatus();
}

}  // namespace tessera::wire
