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
    AlgorithmTraits{.name = "light",
                    .work = WorkKind::kPasses,
                    .samples_all_light = true,
                    .starts_at_lights = true,
                    .joins_camera = true},
    AlgorithmTraits{.name = "direct", .noise = true, .first_hit_aovs = true, .bsdf_lighting = true},
    AlgorithmTraits{.name = "whitted",
                    .bias = Bias::kBiased,
                    .noise = true,
                    .first_hit_aovs = true,
                    .samples_all_light = true},
    AlgorithmTraits{.name = "raycast",
                    .bias = Bias::kBiased,
                    .noise = true,
                    .first_hit_aovs = true,
                    .samples_all_light = true},
};

std::vector<AlgorithmTraits>& table() {
  static std::vector<AlgorithmTraits> all(kAlgorithms.begin(), kAlgorithms.end());
  return all;
}

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

}  // namespace tessera::wire
