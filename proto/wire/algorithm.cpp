#include "wire/algorithm.h"

#include <algorithm>
#include <array>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "base/nearest_name.h"

namespace tessera::wire {

namespace {

// The second fills what the first, of few points of the picture, has left.
constexpr std::array kCachePhases{
    PhaseTraits{.name = "first records", .parts = 64, .check = &kIrradianceRecordsCheck},
    PhaseTraits{.name = "records", .parts = 64, .check = &kIrradianceRecordsCheck}};
// Each follows twice as many paths as the one before.
constexpr std::array kGuidePhases{
    PhaseTraits{.name = "first guide", .parts = 16, .merge_width = 16, .check = &kGuideSumsCheck},
    PhaseTraits{.name = "second guide", .parts = 16, .merge_width = 16, .check = &kGuideSumsCheck},
    PhaseTraits{.name = "guide", .parts = 16, .merge_width = 16, .check = &kGuideSumsCheck}};
// Estimates are quick: the scene's patches take as long, and are made for each.
constexpr std::array kRadiosityPhases{
    PhaseTraits{.name = "estimate", .parts = 8, .check = &kEstimateLinksCheck},
    PhaseTraits{.name = "links", .parts = 64, .check = &kPatchLinksCheck},
    PhaseTraits{.name = "solution", .check = &kRadiositySolutionCheck}};

constexpr std::array kAlgorithms{
    AlgorithmTraits{.name = "path",
                    .summary = "paths from the camera, over surfaces",
                    .wavelengths = true,
                    .noise = true,
                    .scatters = true,
                    .shares_paths = true,
                    .first_hit_aovs = true,
                    .layers = LayerStates::kFromCamera,
                    .shadow_layers = true,
                    .lens_ghosts = true,
                    .straight_shadows = true,
                    .bsdf_lighting = true,
                    .reads_probes = true,
                    .blindness = Blindness::kCaustics},
    AlgorithmTraits{.name = "volpath",
                    .summary = "paths from the camera, through media too",
                    .wavelengths = true,
                    .media = true,
                    .noise = true,
                    .scatters = true,
                    .shares_paths = true,
                    .first_hit_aovs = true,
                    .layers = LayerStates::kFromCamera,
                    .shadow_layers = true,
                    .lens_ghosts = true,
                    .straight_shadows = true,
                    .bsdf_lighting = true,
                    .reads_probes = true,
                    .blindness = Blindness::kCaustics},
    AlgorithmTraits{.name = "light",
                    .summary = "paths from the lights, over surfaces: caustics",
                    .wavelengths = true,
                    .work = WorkKind::kPasses,
                    .layers = LayerStates::kFromBothEnds,
                    .samples_all_light = true,
                    .starts_at_lights = true,
                    .reads_probes = true,
                    .blindness = Blindness::kMirrorImages},
    AlgorithmTraits{.name = "direct",
                    .summary = "lights and what they light, without light between surfaces",
                    .wavelengths = true,
                    .noise = true,
                    .scatters = true,
                    .first_hit_aovs = true,
                    .layers = LayerStates::kFromCamera,
                    .shadow_layers = true,
                    .bsdf_lighting = true,
                    .reads_probes = true},
    AlgorithmTraits{.name = "whitted",
                    .summary = "direct light, seen in perfect mirrors and through glass too",
                    .wavelengths = true,
                    .bias = Bias::kBiased,
                    .noise = true,
                    .scatters = true,
                    .first_hit_aovs = true,
                    .layers = LayerStates::kFromCamera,
                    .shadow_layers = true,
                    .samples_all_light = true},
    AlgorithmTraits{.name = "raycast",
                    .summary = "whitted without mirrors and glass",
                    .wavelengths = true,
                    .bias = Bias::kBiased,
                    .noise = true,
                    .scatters = true,
                    .first_hit_aovs = true,
                    .layers = LayerStates::kFromCamera,
                    .shadow_layers = true,
                    .samples_all_light = true},
    AlgorithmTraits{.name = "irradiance-cache",
                    .summary = "paths that end at paint, whose light is interpolated",
                    .why_colors = "records of its cache are met by paths of all wavelengths",
                    .bias = Bias::kBiased,
                    .noise = true,
                    .scatters = true,
                    .first_hit_aovs = true,
                    .samples_all_light = true,
                    .motion = false,
                    .phases = kCachePhases},
    AlgorithmTraits{.name = "ao",
                    .summary = "ambient occlusion: the share of the sky that each point sees",
                    .wavelengths = true,
                    .bias = Bias::kBiased,
                    .noise = true,
                    .scatters = true,
                    .first_hit_aovs = true},
    AlgorithmTraits{.name = "bdpt",
                    .summary = "paths from camera and lights, through media too, joined in all ways",
                    .wavelengths = true,
                    .work = WorkKind::kPasses,
                    .media = true,
                    .first_hit_aovs = true,
                    .layers = LayerStates::kFromBothEnds,
                    .shadow_layers = true,
                    .strategy_layers = true,
                    .lens_ghosts = true,
                    .samples_all_light = true,
                    .starts_at_lights = true,
                    .reads_probes = true,
                    .blindness = Blindness::kCausticsInMirrors},
    AlgorithmTraits{
        .name = "vcm",
        .summary = "bdpt, whose paths also take light from vertices close by: caustics in mirrors",
        .wavelengths = true,
        .work = WorkKind::kPasses,
        .bias = Bias::kConsistent,
        .media = true,
        .first_hit_aovs = true,
        .layers = LayerStates::kFromBothEnds,
        .shadow_layers = true,
        .lens_ghosts = true,
        .samples_all_light = true,
        .starts_at_lights = true},
    AlgorithmTraits{.name = "radiosity",
                    .summary = "all light between patches of diffuse surfaces",
                    .why_colors = "light of its patches is met by paths of all wavelengths",
                    .bias = Bias::kBiased,
                    .noise = true,
                    .scatters = true,
                    .first_hit_aovs = true,
                    .samples_all_light = true,
                    .motion = false,
                    .diffuse_only = true,
                    .lists_instances = true,
                    .phases = kRadiosityPhases},
    AlgorithmTraits{.name = "photon",
                    .summary = "photon mapping: caustics, in mirrors and through glass too",
                    .wavelengths = true,
                    .work = WorkKind::kPasses,
                    .bias = Bias::kConsistent,
                    .first_hit_aovs = true,
                    .layers = LayerStates::kFromBothEnds,
                    .samples_all_light = true,
                    .starts_at_lights = true},
    AlgorithmTraits{.name = "mlt",
                    .summary = "Metropolis: bdpt's paths, changed little by little where they bring light",
                    .wavelengths = true,
                    .work = WorkKind::kPasses,
                    .media = true,
                    .first_hit_aovs = true,
                    .lens_ghosts = true,
                    .samples_all_light = true,
                    .starts_at_lights = true,
                    .blindness = Blindness::kCausticsInMirrors},
    AlgorithmTraits{.name = "guided",
                    .summary = "paths from the camera that learn where light comes from, through media too",
                    .wavelengths = true,
                    .media = true,
                    .noise = true,
                    .scatters = true,
                    .shares_paths = true,
                    .first_hit_aovs = true,
                    .layers = LayerStates::kFromCamera,
                    .shadow_layers = true,
                    .straight_shadows = true,
                    .bsdf_lighting = true,
                    .blindness = Blindness::kCaustics,
                    .phases = kGuidePhases},
};

/// An algorithm that older versions had, and the one to take in its place.
struct RemovedAlgorithm {
  const char *name, *instead, *why;
};
constexpr std::array kRemoved{
    RemovedAlgorithm{"preview", "raycast", "shows what the camera sees, with shadows, in less time"}};

std::vector<AlgorithmTraits>& table() {
  static std::vector<AlgorithmTraits> all(kAlgorithms.begin(), kAlgorithms.end());
  return all;
}

}  // namespace

const char* word_of(Bias bias) {
  switch (bias) {
    case Bias::kUnbiased:
      return "unbiased";
    case Bias::kConsistent:
      return "consistent";
    case Bias::kBiased:
      return "biased";
  }
  return "";
}

const char* word_of(Blindness blindness) {
  switch (blindness) {
    case Blindness::kNone:
      return "";
    case Blindness::kCaustics:
      return "caustics of lights without area";
    case Blindness::kCausticsInMirrors:
      return "mirror images of caustics of lights without area";
    case Blindness::kMirrorImages:
      return "whatever is seen in mirrors and through clear glass";
  }
  return "";
}

std::span<const AlgorithmTraits> algorithms() { return table(); }

std::string spectral_algorithms() {
  std::vector<std::string> names;
  for (const AlgorithmTraits& algorithm : table()) {
    if (algorithm.wavelengths) names.emplace_back(algorithm.name);
  }
  return absl::StrJoin(names, ", ");
}

void add_algorithm(const AlgorithmTraits& algorithm) { table().push_back(algorithm); }

std::string description_of(const AlgorithmTraits& algorithm) {
  const std::string unseen = word_of(algorithm.blindness);
  return absl::StrCat(algorithm.summary, "; ", word_of(algorithm.bias), unseen.empty() ? "" : ", blind to ",
                      unseen);
}

const AlgorithmTraits* find_algorithm(std::string_view name) {
  const std::vector<AlgorithmTraits>& all = table();
  if (name.empty()) return all.data();
  const auto it = std::find_if(all.begin(), all.end(),
                               [&](const AlgorithmTraits& algorithm) { return name == algorithm.name; });
  return it == all.end() ? nullptr : &*it;
}

std::string why_no_algorithm(const std::string& name, std::span<const char* const> others) {
  std::vector<std::string> names;
  for (const AlgorithmTraits& algorithm : table()) names.emplace_back(algorithm.name);
  names.insert(names.end(), others.begin(), others.end());
  const auto* const removed =
      std::find_if(kRemoved.begin(), kRemoved.end(), [&](const auto& row) { return row.name == name; });
  const std::string instead = removed == kRemoved.end()
                                  ? base::did_you_mean(name, names)
                                  : absl::StrCat(" any more; '", removed->instead, "' ", removed->why);
  return absl::StrCat("there is no integrator '", name, "'", instead,
                      "; there is: ", absl::StrJoin(names, ", "));
}

absl::Status check_algorithm_name(const std::string& name) {
  if (find_algorithm(name) != nullptr) return absl::OkStatus();
  return absl::InvalidArgumentError(why_no_algorithm(name));
}

}  // namespace tessera::wire
