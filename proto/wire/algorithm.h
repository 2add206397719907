// The algorithms that make a picture, as all three programs know them: by name, and by what they can do.
// Kernels make them (worker/render/integrator); no name of one is compared anywhere else.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "wire/phases/phase_blob.h"

namespace tessera::wire {

/// Kinds of units of work.
enum class WorkKind : std::uint8_t {
  kTiles,  // samples of a rectangle of pixels
  kPasses  // samples of all pixels, and light that lands anywhere on the film
};

/// Kinds of algorithms: how the mean of many pictures is related to the right one.
enum class Bias : std::uint8_t {
  kUnbiased,    // equal, at any number of samples
  kConsistent,  // equal in the limit of many samples
  kBiased       // another, by design
};

/// "unbiased", "consistent" or "biased".
const char* word_of(Bias bias);

/// Light that an unbiased or consistent algorithm never finds, at any number of samples. Delta lights have no
/// area (points, spots, parallel light); delta surfaces are mirrors, clear glass and clear coats.
enum class Blindness : std::uint8_t {
  kNone,
  kCaustics,           // light of delta lights, by way of delta surfaces
  kCausticsInMirrors,  // the same, but only where it is seen by way of delta surfaces as well
  kMirrorImages        // whatever is seen by way of delta surfaces
};

/// "caustics of lights without area" ...; empty for kNone.
const char* word_of(Blindness blindness);

/// Whether light is told apart by the path that it took (layers/expression.h), and which paths carry the
/// state of an automaton: those from the camera, or those from lights as well.
enum class LayerStates : std::uint8_t { kNone, kFromCamera, kFromBothEnds };

/// A phase of an algorithm: made once a job, before the picture; how much of it unless the job says
/// otherwise.
struct PhaseTraits {
  const char* name;
  std::uint32_t parts = 1;
  std::uint32_t merge_width = 8;
  const PhaseBlobCheck* check = nullptr;  // checks its blobs; null: only who reads them knows what they are
};

/// Settings that one algorithm alone has are the message of RenderSettings and Algorithms with its name.
struct AlgorithmTraits {
  const char* name;
  const char* summary = "";     // for people, in one line
  bool wavelengths = false;     // paths may carry light of wavelengths, and pictures have bands of it
  const char* why_colors = "";  // why they may not, for people
  WorkKind work = WorkKind::kTiles;
  Bias bias = Bias::kUnbiased;
  bool media = false;           // sees participating media; where not, they are left out with a warning
  bool noise = false;           // samples may be taken as noise asks for (RenderSettings.noise)
  bool scatters = false;        // samples may go into several pixels (RenderSettings.reconstruction)
  bool shares_paths = false;    // neighbouring pixels may share light (RenderSettings.path_sharing)
  bool first_hit_aovs = false;  // gives albedo, normal and depth of what a camera ray meets
  LayerStates layers = LayerStates::kNone;
  bool shadow_layers = false;     // has layers of light that something is in the way of (layers/layer_rule.h)
  bool strategy_layers = false;   // has layers of single strategies
  bool lens_ghosts = false;       // light may be sent into the lens (RenderSettings.lens_ghosts)
  bool straight_shadows = false;  // light may pass clear glass unbent (RenderSettings.glass_shadows)
  bool bsdf_lighting =
      false;  // direct light may be found by BSDF sampling alone (RenderSettings.direct_light)
  bool samples_all_light = false;  // light sampling must find all light: none is left to BSDF sampling
  bool starts_at_lights = false;   // light is sampled at its source, without a receiver: no portals
  bool motion = true;              // shapes may move; where not, they are refused
  bool reads_probes = false;       // pixels may be readings of probes (ProbeCamera)
  bool diffuse_only = false;       // knows triangles of diffuse matter and nothing else
  bool lists_instances = false;    // goes over all of them: objects within objects are flattened
  Blindness blindness = Blindness::kNone;
  std::span<const PhaseTraits> phases = {};
};

/// All of them; the first is the default.
std::span<const AlgorithmTraits> algorithms();

/// Names of those that carry light of wavelengths, for people: "path, light".
std::string spectral_algorithms();

/// Adds one that does not come with the kernels, at the start of a program, before anything else is called.
void add_algorithm(const AlgorithmTraits& algorithm);

/// Returns "SUMMARY; KIND", or "SUMMARY; KIND, blind to LIGHT", for people.
std::string description_of(const AlgorithmTraits& algorithm);

/// The algorithm with this name, the default where it is empty; null where there is none.
const AlgorithmTraits* find_algorithm(std::string_view name);

/// Tells, for people, that no algorithm has this name: the one that took its place or the nearest name, then
/// all names that there are, `others` last.
std::string why_no_algorithm(const std::string& name, std::span<const char* const> others = {});

/// Returns InvalidArgument with why_no_algorithm() where no algorithm has this name.
absl::Status check_algorithm_name(const std::string& name);

}  // namespace tessera::wire
