#include "wire/own_settings.h"

#include <google/protobuf/message.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "wire/algorithm.h"
#include "wire/enum_words.h"
#include "wire/limits.h"
#include "wire/scene_numbers.h"

namespace tessera::wire {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

// docs/decisions/0032-radiosity.md
constexpr double kDefaultErrorBound = 0.01;
constexpr double kDefaultResidual = 1e-4;
constexpr std::uint64_t kDefaultRadiosityMemory = std::uint64_t{4} << 30;
constexpr bool kDefaultFinalGather = false;
// docs/decisions/0036-metropolis.md
constexpr std::uint32_t kDefaultMutations = 128, kDefaultCandidates = 32;
constexpr double kDefaultLargeSteps = 0.3, kDefaultStep = 1.0 / 32;
// docs/decisions/0033-irradiance-cache.md
constexpr double kDefaultCacheError = 0.3;
constexpr std::uint32_t kDefaultCacheSamples = 1024;
constexpr std::uint32_t kDefaultGlossyBands = 8;
constexpr double kDefaultLeastReach = 3, kDefaultMostReach = 32;
// docs/decisions/0045-path-guiding.md
constexpr double kDefaultGuidingSamples = 3.5;

template <int kInWishes, int kInJobs>
constexpr bool has_number(OwnSettings own) {
  return kInWishes == static_cast<int>(own) && kInJobs == static_cast<int>(own);
}
using Wishes = v1::RenderSettings;
using Job = v1::Algorithms;
static_assert(has_number<Wishes::kPhotonFieldNumber, Job::kPhotonFieldNumber>(OwnSettings::kPhoton));
static_assert(
    has_number<Wishes::kMetropolisFieldNumber, Job::kMetropolisFieldNumber>(OwnSettings::kMetropolis));
static_assert(has_number<Wishes::kRadiosityFieldNumber, Job::kRadiosityFieldNumber>(OwnSettings::kRadiosity));
static_assert(has_number<Wishes::kIrradianceCacheFieldNumber, Job::kIrradianceCacheFieldNumber>(
    OwnSettings::kIrradianceCache));
static_assert(has_number<Wishes::kPreviewFieldNumber, Job::kPreviewFieldNumber>(OwnSettings::kPreview));
static_assert(has_number<Wishes::kAmbientOcclusionFieldNumber, Job::kAmbientOcclusionFieldNumber>(
    OwnSettings::kAmbientOcclusion));
static_assert(has_number<Wishes::kGuidingFieldNumber, Job::kGuidingFieldNumber>(OwnSettings::kGuiding));

v1::PhotonSettings resolved(v1::PhotonSettings photon) {
  photon.set_map(or_default(photon.map()));
  photon.set_light(or_default(photon.light()));
  return photon;
}

v1::MetropolisSettings resolved(v1::MetropolisSettings metropolis) {
  if (!metropolis.has_mutations()) metropolis.set_mutations(kDefaultMutations);
  if (!metropolis.has_candidates()) metropolis.set_candidates(kDefaultCandidates);
  if (!metropolis.has_large_steps()) metropolis.set_large_steps(kDefaultLargeSteps);
  if (!metropolis.has_step()) metropolis.set_step(kDefaultStep);
  return metropolis;
}

v1::RadiositySettings resolved(v1::RadiositySettings radiosity) {
  if (radiosity.error_bound() == 0) radiosity.set_error_bound(kDefaultErrorBound);
  if (radiosity.residual() == 0) radiosity.set_residual(kDefaultResidual);
  if (radiosity.memory_limit() == 0) radiosity.set_memory_limit(kDefaultRadiosityMemory);
  if (!radiosity.has_final_gather()) radiosity.set_final_gather(kDefaultFinalGather);
  return radiosity;
}

v1::IrradianceCache resolved(v1::IrradianceCache cache) {
  if (!cache.has_error()) cache.set_error(kDefaultCacheError);
  if (!cache.has_samples()) cache.set_samples(kDefaultCacheSamples);
  if (!cache.has_least_reach()) cache.set_least_reach(kDefaultLeastReach);
  if (!cache.has_glossy_bands()) cache.set_glossy_bands(kDefaultGlossyBands);
  if (!cache.has_most_reach()) cache.set_most_reach(kDefaultMostReach);
  return cache;
}

v1::PreviewSettings resolved(v1::PreviewSettings preview) {
  preview.set_shadows(or_default(preview.shadows()));
  if (!preview.has_ambient()) preview.set_ambient(1);
  return preview;
}

v1::GuidingSettings resolved(v1::GuidingSettings guiding) {
  if (!guiding.has_samples()) guiding.set_samples(kDefaultGuidingSamples);
  return guiding;
}

/// OK where `value` is in [least, most].
template <class Number>
absl::Status check_range(const char* name, Number value, std::type_identity_t<Number> least,
                         std::type_identity_t<Number> most) {
  if (value >= least && value <= most) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(name, " is ", value, "; ", least, " to ", most, " was expected"));
}

/// OK where `value` is in (0, 1].
absl::Status check_share(const char* name, double value) {
  if (value > 0 && value <= 1) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(name, " is ", value, "; more than 0, and at most 1 was expected"));
}

absl::Status check(const v1::PhotonSettings& photon) {
  if (photon.has_radius()) {
    if (auto s = check_range("photon.radius", photon.radius(), kMinPhotonRadius, kMaxPhotonRadius); !s.ok())
      return s;
  }
  if (photon.has_caustic_radius()) {
    if (auto s =
            check_range("photon.caustic_radius", photon.caustic_radius(), kMinPhotonRadius, kMaxPhotonRadius);
        !s.ok())
      return s;
  }
  if (!photon.has_photons()) return absl::OkStatus();
  return check_range("photon.photons", photon.photons(), 1, kMaxPhotons);
}

absl::Status check(const v1::MetropolisSettings& metropolis) {
  if (auto s = check_range("metropolis.mutations", metropolis.mutations(), 1, kMaxMutations); !s.ok())
    return s;
  if (auto s = check_range("metropolis.candidates", metropolis.candidates(), 1, kMaxCandidates); !s.ok())
    return s;
  if (auto s = check_range("metropolis.large_steps", metropolis.large_steps(), kMinLargeSteps, 1); !s.ok())
    return s;
  return check_range("metropolis.step", metropolis.step(), kMinStep, kMaxStep);
}

absl::Status check(const v1::RadiositySettings& radiosity) {
  if (auto s = check_share("radiosity.error_bound", radiosity.error_bound()); !s.ok()) return s;
  if (auto s = check_share("radiosity.residual", radiosity.residual()); !s.ok()) return s;
  if (radiosity.smallest_area() >= 0 && radiosity.smallest_area() < INFINITY) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("radiosity.smallest_area is ", radiosity.smallest_area(), "; 0 or an area was expected"));
}

absl::Status check(const v1::IrradianceCache& cache) {
  if (auto s = check_range("irradiance_cache.error", cache.error(), kLeastCacheError, kMostCacheError);
      !s.ok())
    return s;
  if (auto s =
          check_range("irradiance_cache.samples", cache.samples(), kLeastCacheSamples, kMostCacheSamples);
      !s.ok())
    return s;
  if (auto s =
          check_range("irradiance_cache.least_reach", cache.least_reach(), kLeastCacheReach, kMostCacheReach);
      !s.ok())
    return s;
  if (cache.glossy_bands() != 0) {
    if (auto s = check_range("irradiance_cache.glossy_bands", cache.glossy_bands(), kLeastGlossyBands,
                             kMostGlossyBands);
        !s.ok())
      return s;
  }
  return check_range("irradiance_cache.most_reach", cache.most_reach(), cache.least_reach(), kMostCacheReach);
}

/// The settings that single algorithms have and `message` holds: those of v1::RenderSettings, v1::Algorithms.
std::vector<const FieldDescriptor*> own_settings_in(const Message& message) {
  std::vector<const FieldDescriptor*> fields;
  message.GetReflection()->ListFields(message, &fields);
  std::erase_if(fields, [](const FieldDescriptor* field) {
    return std::ranges::find(algorithms(), static_cast<OwnSettings>(field->number()),
                             &AlgorithmTraits::own_settings) == algorithms().end();
  });
  return fields;
}

absl::Status check_owner_of(const Message& message, const std::string& integrator) {
  const OwnSettings own = find_algorithm(integrator)->own_settings;
  for (const FieldDescriptor* const field : own_settings_in(message)) {
    if (field->number() == static_cast<int>(own)) continue;
    std::vector<std::string> owners;
    for (const AlgorithmTraits& algorithm : algorithms()) {
      if (field->number() == static_cast<int>(algorithm.own_settings))
        owners.push_back(absl::StrCat("'", algorithm.name, "'"));
    }
    return absl::InvalidArgumentError(absl::StrCat("integrator '", integrator, "' has no settings '",
                                                   field->name(), "', which are for ",
                                                   absl::StrJoin(owners, ", ")));
  }
  return absl::OkStatus();
}

}  // namespace

void resolve_own_settings(const v1::RenderSettings& wishes, v1::Algorithms& algorithms) {
  const AlgorithmTraits* const algorithm = find_algorithm(algorithms.integrator());
  if (algorithm == nullptr) return;
  switch (algorithm->own_settings) {
    case OwnSettings::kNone:
      return;
    case OwnSettings::kPhoton:
      *algorithms.mutable_photon() = resolved(wishes.photon());
      return;
    case OwnSettings::kMetropolis:
      *algorithms.mutable_metropolis() = resolved(wishes.metropolis());
      return;
    case OwnSettings::kRadiosity:
      *algorithms.mutable_radiosity() = resolved(wishes.radiosity());
      return;
    case OwnSettings::kIrradianceCache:
      *algorithms.mutable_irradiance_cache() = resolved(wishes.irradiance_cache());
      return;
    case OwnSettings::kPreview:
      *algorithms.mutable_preview() = resolved(wishes.preview());
      return;
    case OwnSettings::kAmbientOcclusion:
      *algorithms.mutable_ambient_occlusion() = wishes.ambient_occlusion();
      return;
    case OwnSettings::kGuiding:
      *algorithms.mutable_guiding() = resolved(wishes.guiding());
      return;
  }
}

absl::Status check_owner(const v1::RenderSettings& wishes, const std::string& integrator) {
  return check_owner_of(wishes, integrator);
}

absl::Status check_own_settings(const v1::Algorithms& algorithms) {
  if (auto s = check_owner_of(algorithms, algorithms.integrator()); !s.ok()) return s;
  if (find_algorithm(algorithms.integrator())->own_settings != OwnSettings::kNone &&
      own_settings_in(algorithms).empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat("integrator '", algorithms.integrator(), "' has settings of its own; the job has none"));
  }
  if (algorithms.has_photon()) return check(algorithms.photon());
  if (algorithms.has_metropolis()) return check(algorithms.metropolis());
  if (algorithms.has_radiosity()) return check(algorithms.radiosity());
  if (algorithms.has_irradiance_cache()) return check(algorithms.irradiance_cache());
  if (algorithms.has_preview())
    return check_range("preview.ambient", algorithms.preview().ambient(), 0, kMaxAmbient);
  if (algorithms.has_guiding()) {
    return check_range("guiding.samples", algorithms.guiding().samples(), kLeastGuidingSamples,
                       kMostGuidingSamples);
  }
  return check_range("ambient_occlusion.distance", algorithms.ambient_occlusion().distance(), 0,
                     kLargestSceneNumber);
}

}  // namespace tessera::wire
