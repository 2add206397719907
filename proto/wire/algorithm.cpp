#include "wire/algorithm.h"

#include <algorithm>
#include <array>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"

namespace tessera::wire {

namespace {

constexpr std::array kAlgorithms{
    AlgorithmTraits{.name = "path", .noise = true, .first_hit_aovs = true, .bsdf_lighting = true},
    AlgorithmTraits{
        .name = "volpath", .media = true, .noise = true, .first_hit_aovs = true, .bsdf_lighting = true},
    AlgorithmTraits{
        .name = "light", .work = WorkKind::kPasses, .starts_at_lights = true, .joins_camera = true},
};

std::vector<AlgorithmTraits>& table() {
  static std::vector<AlgorithmTraits> all(kAlgorithms.begin(), kAlgorithms.end());
  return all;
}

/// AOVs of what a camera ray meets first.
bool is_first_hit_aov(std::string_view aov) { return aov == "albedo" || aov == "normal" || aov == "depth"; }

}  // namespace

std::span<const AlgorithmTraits> algorithms() { return table(); }

void add_algorithm(const AlgorithmTraits& algorithm) { table().push_back(algorithm); }

const AlgorithmTraits* find_algorithm(std::string_view name) {
  const std::vector<AlgorithmTraits>& all = table();
  if (name.empty()) return all.data();
  const auto it = std::find_if(all.begin(), all.end(),
                               [&](const AlgorithmTraits& algorithm) { return name == algorithm.name; });
  return it == all.end() ? nullptr : &*it;
}

absl::Status check_algorithm_name(const std::string& name) {
  if (find_algorithm(name) != nullptr) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(
      "there is no integrator '", name, "'; there is: ",
      absl::StrJoin(table(), ", ", [](std::string* out, const AlgorithmTraits& a) { out->append(a.name); })));
}

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

}  // namespace tessera::wire
