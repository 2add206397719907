#include "wire/job_check.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "wire/algorithm.h"
#include "wire/aov_channels.h"
#include "wire/enum_words.h"
#include "wire/limits.h"
#include "wire/scene_numbers.h"

namespace tessera::wire {

namespace {

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
  if (!algorithm->first_hit_aovs) {
    for (const int aov : spec.view().aovs()) {
      if (is_first_hit(static_cast<v1::AOV>(aov))) return cannot("gives no albedo, normal, depth or id");
    }
  }
  if (const double distance = asked.ambient_occlusion().distance();
      !(distance >= 0 && distance <= kLargestSceneNumber)) {
    return absl::InvalidArgumentError(absl::StrCat("ambient_occlusion.distance is ", distance, "; 0 to ",
                                                   kLargestSceneNumber, " was expected"));
  }
  if (spec.view().layers_size() > 0 && algorithm->layers == LayerStates::kNone)
    return cannot("cannot tell the paths of light apart: layers are not for it");
  const auto has_name = [](const v1::Phase& phase, const PhaseTraits& own) {
    return phase.name() == own.name;
  };
  if (!std::equal(spec.cut().phases().begin(), spec.cut().phases().end(), algorithm->phases.begin(),
                  algorithm->phases.end(), has_name)) {
    const std::string own = absl::StrJoin(
        algorithm->phases, ", ", [](std::string* out, const PhaseTraits& p) { out->append(p.name); });
    return cannot(absl::StrCat("has other phases than the job: ", own.empty() ? "none" : own,
                               " (the job has ", spec.cut().phases_size(), ")"));
  }
  return absl::OkStatus();
}

absl::Status check_irradiance_cache(const v1::Algorithms& asked) {
  if (find_algorithm(asked.integrator())->irradiance_cache != asked.has_irradiance_cache()) {
    return absl::InvalidArgumentError(absl::StrCat("integrator '", asked.integrator(), "' keeps ",
                                                   asked.has_irradiance_cache() ? "no" : "an",
                                                   " irradiance cache: the job says otherwise"));
  }
  if (!asked.has_irradiance_cache()) return absl::OkStatus();
  const v1::IrradianceCache& cache = asked.irradiance_cache();
  const auto check = [](const char* name, double value, double least, double most) {
    if (value >= least && value <= most) return absl::OkStatus();
    return absl::InvalidArgumentError(
        absl::StrCat("irradiance_cache.", name, " is ", value, "; ", least, " to ", most, " was expected"));
  };
  if (auto s = check("error", cache.error(), kLeastCacheError, kMostCacheError); !s.ok()) return s;
  if (auto s = check("samples", cache.samples(), kLeastCacheSamples, kMostCacheSamples); !s.ok()) return s;
  if (auto s = check("least_reach", cache.least_reach(), kLeastCacheReach, kMostCacheReach); !s.ok())
    return s;
  return check("most_reach", cache.most_reach(), cache.least_reach(), kMostCacheReach);
}

absl::Status check_radiosity(const v1::JobSpec& spec) {
  const v1::Algorithms& algorithms = spec.content().algorithms();
  if (find_algorithm(algorithms.integrator())->diffuse_only != algorithms.has_radiosity()) {
    return absl::InvalidArgumentError(absl::StrCat("integrator '", algorithms.integrator(), "' has ",
                                                   algorithms.has_radiosity() ? "no " : "",
                                                   "settings of radiosity: the job says otherwise"));
  }
  if (!algorithms.has_radiosity()) return absl::OkStatus();
  const v1::RadiositySettings& asked = algorithms.radiosity();
  const auto check = [](const char* name, double value, double most) {
    if (value > 0 && value <= most) return absl::OkStatus();
    return absl::InvalidArgumentError(absl::StrCat("radiosity.", name, " is ", value,
                                                   "; more than 0, and at most ", most, " was expected"));
  };
  if (auto s = check("error_bound", asked.error_bound(), 1); !s.ok()) return s;
  if (auto s = check("residual", asked.residual(), 1); !s.ok()) return s;
  if (asked.smallest_area() >= 0 && asked.smallest_area() < INFINITY) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("radiosity.smallest_area is ", asked.smallest_area(), "; 0 or an area was expected"));
}

absl::Status check_preview(const v1::Algorithms& asked) {
  if (find_algorithm(asked.integrator())->rasterizes != asked.has_preview()) {
    return absl::InvalidArgumentError(absl::StrCat("integrator '", asked.integrator(), "' has ",
                                                   asked.has_preview() ? "no " : "",
                                                   "settings of a preview: the job says otherwise"));
  }
  const double ambient = asked.preview().ambient();
  if (ambient >= 0 && ambient <= kMaxAmbient) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("preview.ambient is ", ambient, "; 0 to ", kMaxAmbient, " was expected"));
}

absl::Status check_photons(const v1::JobSpec& spec) {
  const v1::Algorithms& asked = spec.content().algorithms();
  if (!asked.has_photon()) return absl::OkStatus();
  if (!find_algorithm(asked.integrator())->photons) {
    return absl::InvalidArgumentError(absl::StrCat("integrator '", asked.integrator(),
                                                   "' traces no photons: photon settings are not for it"));
  }
  const v1::PhotonSettings& photon = asked.photon();
  if (photon.has_radius() && !(photon.radius() >= kMinPhotonRadius && photon.radius() <= kMaxPhotonRadius)) {
    return absl::InvalidArgumentError(absl::StrCat("photon.radius is ", photon.radius(), "; ",
                                                   kMinPhotonRadius, " to ", kMaxPhotonRadius,
                                                   " was expected"));
  }
  if (photon.has_photons() && (photon.photons() < 1 || photon.photons() > kMaxPhotons)) {
    return absl::InvalidArgumentError(
        absl::StrCat("photon.photons is ", photon.photons(), "; 1 to ", kMaxPhotons, " was expected"));
  }
  return absl::OkStatus();
}

absl::Status check_noise(const v1::JobSpec& spec) {
  const double noise = spec.samples().noise();
  if (noise == 0) return absl::OkStatus();
  if (!(noise >= kMinNoise && noise <= kMaxNoise)) {
    return absl::InvalidArgumentError(
        absl::StrCat("samples.noise is ", noise, "; 0 or ", kMinNoise, " to ", kMaxNoise, " was expected"));
  }
  if (spec.samples().spp() < kMinAdaptiveSamples) {
    return absl::InvalidArgumentError(absl::StrCat("samples.spp is ", spec.samples().spp(),
                                                   "; with samples.noise it is the cap, and ",
                                                   kMinAdaptiveSamples, " or more was expected"));
  }
  if (spec.cut().tile_size() % kNoiseBlock != 0) {
    return absl::InvalidArgumentError(absl::StrCat("tile_size is ", spec.cut().tile_size(),
                                                   "; with samples.noise a multiple of ", kNoiseBlock,
                                                   " was expected"));
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
  if (auto s = check_enums(spec); !s.ok()) return s;
  if (auto s = check_algorithm(spec); !s.ok()) return s;
  if (auto s = check_irradiance_cache(spec.content().algorithms()); !s.ok()) return s;
  if (auto s = check_radiosity(spec); !s.ok()) return s;
  if (auto s = layers::check_layers(layers_of(spec.view())); !s.ok()) return s;
  if (auto s = check_preview(spec.content().algorithms()); !s.ok()) return s;
  if (auto s = check_photons(spec); !s.ok()) return s;
  return check_noise(spec);
}

void add_phases(v1::JobSpec& spec) {
  spec.mutable_cut()->clear_phases();
  for (const PhaseTraits& own : find_algorithm(spec.content().algorithms().integrator())->phases) {
    v1::Phase& phase = *spec.mutable_cut()->add_phases();
    phase.set_name(own.name);
    phase.set_parts(own.parts);
    phase.set_merge_width(own.merge_width);
  }
}

bool works_in_passes(const v1::JobSpec& spec) {
  const AlgorithmTraits* const algorithm = find_algorithm(spec.content().algorithms().integrator());
  return algorithm != nullptr && algorithm->work == WorkKind::kPasses;
}

}  // namespace tessera::wire
