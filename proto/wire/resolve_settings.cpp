#include "wire/resolve_settings.h"

#include <algorithm>

#include "wire/algorithm.h"
#include "wire/limits.h"

namespace tessera::wire {
namespace {

constexpr std::uint32_t kDefaultSpp = 16;
constexpr std::uint32_t kDefaultMaxDepth = 5;  // pbrt's
// Radiosity
constexpr double kDefaultErrorBound = 0.01;
constexpr double kDefaultResidual = 1e-4;
constexpr std::uint64_t kDefaultRadiosityMemory = std::uint64_t{4} << 30;
constexpr bool kDefaultFinalGather = false;  // docs/decisions/0032-radiosity.md

/// The value, or where it is UNSPECIFIED the default: every enum's first value after that.
template <class Enum>
Enum or_default(Enum value) {
  return value == Enum{} ? static_cast<Enum>(1) : value;
}

v1::IrradianceCache resolved(const v1::IrradianceCache& wishes) {
  v1::IrradianceCache cache = wishes;
  if (!cache.has_error()) cache.set_error(0.3);
  if (!cache.has_samples()) cache.set_samples(1024);
  if (!cache.has_least_reach()) cache.set_least_reach(3);
  if (!cache.has_most_reach()) cache.set_most_reach(32);
  return cache;
}

v1::RadiositySettings resolved(v1::RadiositySettings wishes) {
  if (wishes.error_bound() == 0) wishes.set_error_bound(kDefaultErrorBound);
  if (wishes.residual() == 0) wishes.set_residual(kDefaultResidual);
  if (wishes.memory_limit() == 0) wishes.set_memory_limit(kDefaultRadiosityMemory);
  if (!wishes.has_final_gather()) wishes.set_final_gather(kDefaultFinalGather);
  return wishes;
}

v1::PreviewSettings resolved(const v1::PreviewSettings& wishes) {
  v1::PreviewSettings preview = wishes;
  preview.set_shadows(or_default(wishes.shadows()));
  if (!preview.has_ambient()) preview.set_ambient(1);
  return preview;
}

}  // namespace

void resolve_settings(const v1::RenderSettings& wishes, v1::JobSpec& job) {
  v1::Algorithms& algorithms = *job.mutable_content()->mutable_algorithms();
  algorithms.set_integrator(wishes.integrator().empty() ? wire::algorithms().front().name
                                                        : wishes.integrator());
  algorithms.set_intersection(or_default(wishes.intersection()));
  algorithms.set_direct_light(or_default(wishes.direct_light()));
  algorithms.set_light_selection(or_default(wishes.light_selection()));
  algorithms.set_traversal(or_default(wishes.traversal()));
  const AlgorithmTraits* const algorithm = find_algorithm(algorithms.integrator());
  if (algorithm != nullptr && algorithm->irradiance_cache)
    *algorithms.mutable_irradiance_cache() = resolved(wishes.irradiance_cache());
  if (algorithm != nullptr && algorithm->occlusion_distance)
    *algorithms.mutable_ambient_occlusion() = wishes.ambient_occlusion();
  if (algorithm != nullptr && algorithm->diffuse_only)
    *algorithms.mutable_radiosity() = resolved(wishes.radiosity());
  if (algorithm != nullptr && algorithm->rasterizes)
    *algorithms.mutable_preview() = resolved(wishes.preview());
  if (algorithm != nullptr && algorithm->photons) {
    v1::PhotonSettings& photon = *algorithms.mutable_photon();
    photon = wishes.photon();
    photon.set_map(or_default(photon.map()));
    photon.set_light(or_default(photon.light()));
  }
  v1::JobSpec::View& view = *job.mutable_view();
  view.set_sampler(or_default(wishes.sampler()));
  view.set_seed(wishes.seed());
  view.set_max_depth(std::min(wishes.has_max_depth() ? wishes.max_depth() : kDefaultMaxDepth, kMaxDepth));
  *view.mutable_layers() = wishes.layers();
  job.mutable_samples()->set_spp(wishes.spp() != 0 ? wishes.spp() : kDefaultSpp);
  job.mutable_samples()->set_noise(wishes.noise());
}

}  // namespace tessera::wire
