#include "wire/job_check.h"

#include <algorithm>
#include <bit>
#include <optional>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "layers/layer_rule.h"
#include "wire/algorithm.h"
#include "wire/aov_channels.h"
#include "wire/enum_words.h"
#include "wire/film_sensor.h"
#include "wire/lens_ghosts.h"
#include "wire/limits.h"
#include "wire/pixel_filter.h"
#include "wire/scene_views.h"
#include "wire/settings.h"

namespace tessera::wire {

namespace {

absl::Status check_layer_parts(const v1::JobSpec& spec, const AlgorithmTraits& algorithm) {
  const auto cannot = [&](const std::string& why) {
    return absl::InvalidArgumentError(absl::StrCat("integrator '", algorithm.name, "' ", why));
  };
  if (spec.view().layers_size() > 0 && algorithm.layers == LayerStates::kNone)
    return cannot("cannot tell the paths of light apart: layers are not for it");
  for (const v1::Layer& layer : spec.view().layers()) {
    const absl::StatusOr<layers::LayerRule> rule = layers::parse_rule(layer.expression());
    if (!rule.ok()) continue;  // layers::check_layers says so
    const bool shadow = rule->part == layers::Part::kShadow;
    const std::string not_for_it = absl::StrCat(": layer '", layer.name(), "' is not for it");
    if (shadow && !algorithm.shadow_layers)
      return cannot("does not see what is in the way of lights" + not_for_it);
    if (shadow && spec.content().algorithms().direct_light() == v1::DIRECT_LIGHT_BSDF)
      return cannot("with direct_light 'bsdf' does not see what is in the way of lights" + not_for_it);
    if (!shadow && rule->part != layers::Part::kAll && !algorithm.strategy_layers)
      return cannot("has no strategies of its own" + not_for_it);
  }
  return absl::OkStatus();
}

/// The phase that comes before the picture, after the algorithm's own, where noise decides how many samples
/// are taken; and the pixels of the crop for which one part of it is made: a second of work at most, where
/// samples do not take long.
constexpr const char* kNoisePhase = "noise";
constexpr std::uint64_t kPilotPixels = std::uint64_t{1} << 15;
constexpr std::uint64_t kMostPilotParts = 1024;

/// The algorithm's phases, and the pilot where noise decides how many samples are taken.
std::vector<PhaseTraits> phases_of(const v1::JobSpec& spec, const AlgorithmTraits& algorithm) {
  std::vector<PhaseTraits> phases(algorithm.phases.begin(), algorithm.phases.end());
  if (spec.samples().noise() != 0) {
    const v1::PixelRect& crop = spec.cut().crop();
    const std::uint64_t pixels = std::uint64_t{crop.x1() - crop.x0()} * (crop.y1() - crop.y0());
    const std::uint64_t parts = std::clamp<std::uint64_t>(pixels / kPilotPixels, 1, kMostPilotParts);
    phases.push_back({.name = kNoisePhase,
                      .parts = static_cast<std::uint32_t>(parts),
                      .merge_width = 64,
                      .check = &kNoisePilotCheck});
  }
  return phases;
}

absl::Status check_algorithm(const v1::JobSpec& spec) {
  const v1::Algorithms& asked = spec.content().algorithms();
  if (auto s = check_algorithm_name(asked.integrator()); !s.ok()) return s;
  const AlgorithmTraits* const algorithm = find_algorithm(asked.integrator());
  const auto cannot = [&](const std::string& why) {
    return absl::InvalidArgumentError(absl::StrCat("integrator '", algorithm->name, "' ", why));
  };
  if (spec.samples().noise() != 0 && !algorithm->noise)
    return cannot("takes the same samples everywhere: noise is not for it");
  if (!algorithm->bsdf_lighting && asked.direct_light() == v1::DIRECT_LIGHT_BSDF) {
    return cannot("has its own way to find direct light: 'bsdf' is not for it");
  }
  if (asked.color() == v1::COLOR_SPECTRAL) {
    const std::string why = algorithm->why_colors;
    if (!algorithm->wavelengths)
      return cannot(absl::StrCat("carries red, green and blue", why.empty() ? "" : ", as ", why,
                                 ": color 'spectral' is for ", spectral_algorithms()));
    if (asked.photon().map() == v1::PHOTON_MAP_CLASSIC)
      return cannot(
          "with map 'classic' has one set of wavelengths for the whole picture: color 'spectral' is "
          "for map 'progressive'");
  }
  if (!algorithm->straight_shadows && asked.glass_shadows() == v1::GLASS_SHADOWS_STRAIGHT)
    return cannot("does not let light pass glass unbent: glass_shadows 'straight' is not for it");
  if (!algorithm->first_hit_aovs) {
    for (const int aov : spec.view().aovs()) {
      if (is_first_hit(static_cast<v1::AOV>(aov)))
        return cannot("gives nothing of what camera rays meet first: no albedo, normal, depth, id and so on");
    }
  }
  if (spec.samples().noise() != 0 &&
      std::ranges::find(spec.view().aovs(), v1::AOV_HALVES) != spec.view().aovs().end()) {
    return absl::InvalidArgumentError(
        "aov 'halves': with samples.noise, no fixed half of the samples is every pixel's");
  }
  const bool counts = asked.accelerator() > v1::ACCELERATOR_EMBREE;
  if (!counts && std::ranges::find(spec.view().aovs(), v1::AOV_VISITS) != spec.view().aovs().end()) {
    return absl::InvalidArgumentError(
        "aov 'visits': accelerator 'embree' does not tell what rays visit; all others do");
  }
  if (auto s = check_layer_parts(spec, *algorithm); !s.ok()) return s;
  const auto has_name = [](const v1::Phase& phase, const PhaseTraits& own) {
    return phase.name() == own.name;
  };
  const std::vector<PhaseTraits> phases = phases_of(spec, *algorithm);
  if (!std::equal(spec.cut().phases().begin(), spec.cut().phases().end(), phases.begin(), phases.end(),
                  has_name)) {
    const std::string own =
        absl::StrJoin(phases, ", ", [](std::string* out, const PhaseTraits& p) { out->append(p.name); });
    return cannot(absl::StrCat("has other phases than the job: ", own.empty() ? "none" : own,
                               " (the job has ", spec.cut().phases_size(), ")"));
  }
  return absl::OkStatus();
}

/// The settings that its integrator alone has, and no others.
absl::Status check_own_settings(const v1::Algorithms& algorithms) {
  const std::string& integrator = algorithms.integrator();
  if (auto s = check_owner(algorithms, integrator); !s.ok()) return s;
  const FieldType* const own = own_settings(*algorithms.GetDescriptor(), integrator);
  if (own == nullptr || algorithms.GetReflection()->HasField(algorithms, own)) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("integrator '", integrator, "' has settings of its own; the job has none"));
}

absl::Status check_sampler(const v1::JobSpec& spec) {
  const std::uint32_t bits = spec.view().sample_bits(), expected = sample_bits_of(spec);
  if (bits == expected) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("view.sample_bits is ", bits, "; with sampler ", word_of(spec.view().sampler()), " and ",
                   spec.samples().spp(), " samples a pixel ", expected, " was expected"));
}

absl::Status check_noise(const v1::JobSpec& spec) {
  if (spec.samples().noise() == 0) return absl::OkStatus();
  if (views_of(spec) > 1) {
    return absl::InvalidArgumentError(
        "samples.noise: its pilot sees one view, and the job has several; it can render one of them alone");
  }
  if (spec.samples().spp() < kLeastNoiseSamples) {
    return absl::InvalidArgumentError(absl::StrCat("samples.spp is ", spec.samples().spp(),
                                                   "; with samples.noise it is the cap, and ",
                                                   kLeastNoiseSamples, " or more was expected"));
  }
  if (spec.cut().samples_per_unit() < spec.samples().spp()) {
    return absl::InvalidArgumentError(absl::StrCat("samples_per_unit is ", spec.cut().samples_per_unit(),
                                                   "; with samples.noise a unit takes all ",
                                                   spec.samples().spp(), " samples"));
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status check_settings(const v1::JobSpec& spec) {
  if (auto s = check_known(spec); !s.ok()) return s;
  if (auto s = check_algorithm(spec); !s.ok()) return s;
  if (auto s = check_own_settings(spec.content().algorithms()); !s.ok()) return s;
  if (auto s = check_values(spec.content().algorithms()); !s.ok()) return s;
  if (auto s = check_values(spec.view()); !s.ok()) return s;
  if (auto s = check_values(spec.samples()); !s.ok()) return s;
  if (auto s = check_film_sensor(spec); !s.ok()) return s;
  if (auto s = layers::check_layers(layers_of(spec.view())); !s.ok()) return s;
  if (const std::size_t channels = channels_of(spec.view()).size(); channels > kMaxChannels) {
    return absl::InvalidArgumentError(absl::StrCat("the AOVs, bands and layers have ", channels,
                                                   " channels; a result has ", kMaxChannels, " at most"));
  }
  if (auto s = check_sampler(spec); !s.ok()) return s;
  if (spec.view().reconstruction() == v1::RECONSTRUCTION_SCATTER) {
    if (auto s = allows_scattering(spec); !s.ok()) return s;
  }
  if (spec.view().path_sharing() != 0 && spec.view().path_sharing() != v1::PATH_SHARING_OFF) {
    if (auto s = allows_sharing(spec); !s.ok()) return s;
  }
  if (spec.view().lens_ghosts() == v1::LENS_GHOSTS_LIGHTS) {
    if (auto s = allows_light_into_lens(spec); !s.ok()) return s;
  }
  return check_noise(spec);
}

absl::Status allows_sharing(const v1::JobSpec& spec) {
  const std::string& integrator = spec.content().algorithms().integrator();
  const AlgorithmTraits* const algorithm = find_algorithm(integrator);
  if (algorithm == nullptr || !algorithm->shares_paths) {
    return absl::InvalidArgumentError(absl::StrCat(
        "integrator '", integrator, "' has no paths that pixels share: path_sharing is not for it"));
  }
  if (spec.view().lens_ghosts() == v1::LENS_GHOSTS_LIGHTS) {
    return absl::InvalidArgumentError(
        "path_sharing does not go with lens_ghosts 'lights', whose samples are of all pixels");
  }
  if (spec.view().layers_size() > 0) {
    return absl::InvalidArgumentError(
        "path_sharing does not go with layers: shared light does not tell by which path it came");
  }
  return absl::OkStatus();
}

std::string kind_of(const v1::Algorithms& asked) {
  const AlgorithmTraits* const algorithm = find_algorithm(asked.integrator());
  if (algorithm == nullptr) return "";
  return word_of(asked.glass_shadows() == v1::GLASS_SHADOWS_STRAIGHT ? Bias::kBiased : algorithm->bias);
}

std::uint32_t sample_bits_of(const v1::JobSpec& spec) {
  if (spec.view().sampler() != v1::SAMPLER_Z_SOBOL || spec.samples().spp() == 0) return 0;
  return static_cast<std::uint32_t>(std::bit_width(spec.samples().spp() - 1));
}

void add_phases(v1::JobSpec& spec) {
  spec.mutable_cut()->clear_phases();
  for (const PhaseTraits& own : phases_of(spec, *find_algorithm(spec.content().algorithms().integrator()))) {
    v1::Phase& phase = *spec.mutable_cut()->add_phases();
    phase.set_name(own.name);
    phase.set_parts(own.parts);
    phase.set_merge_width(own.merge_width);
  }
}

std::optional<ExpectedBlob> expected_blob(const v1::JobSpec& spec, const v1::WorkUnit& unit) {
  const std::uint32_t phase = unit.has_part() ? unit.part().phase() : unit.merge().phase();
  const AlgorithmTraits* const algorithm = find_algorithm(spec.content().algorithms().integrator());
  if (algorithm == nullptr || static_cast<int>(phase) >= spec.cut().phases_size()) return std::nullopt;
  const std::vector<PhaseTraits> phases = phases_of(spec, *algorithm);
  if (phase >= phases.size() || phases[phase].check == nullptr) return std::nullopt;
  const v1::Phase& own = spec.cut().phases(static_cast<int>(phase));
  const v1::PixelRect& crop = spec.cut().crop();
  PhaseBlob blob{.parts = own.parts(),
                 .crop = {crop.x0(), crop.y0(), crop.x1(), crop.y1()},
                 .glossy_bands = spec.content().algorithms().irradiance_cache().glossy_bands(),
                 .memory_limit = spec.content().algorithms().radiosity().memory_limit()};
  if (unit.has_part()) {
    blob.first_part = unit.part().part(), blob.end_part = blob.first_part + 1;
  } else {
    std::uint64_t width = 1;
    for (std::uint32_t level = 0; level < unit.merge().level() && width < own.parts(); ++level)
      width *= own.merge_width();
    const auto until = [&](std::uint64_t index) {
      return static_cast<std::uint32_t>(std::min<std::uint64_t>(index * width, own.parts()));
    };
    blob.first_part = until(unit.merge().index()), blob.end_part = until(unit.merge().index() + 1ull);
  }
  return ExpectedBlob{.check = phases[phase].check, .blob = blob};
}

bool works_in_passes(const v1::JobSpec& spec) {
  const AlgorithmTraits* const algorithm = find_algorithm(spec.content().algorithms().integrator());
  return algorithm != nullptr &&
         (algorithm->work == WorkKind::kPasses || spec.view().lens_ghosts() == v1::LENS_GHOSTS_LIGHTS);
}

}  // namespace tessera::wire
