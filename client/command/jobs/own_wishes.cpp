#include "command/jobs/own_wishes.h"

namespace tessera::client {
namespace {

v1::PhotonSettings message_of(const PhotonWishes& wishes) {
  v1::PhotonSettings photon;
  if (wishes.radius) photon.set_radius(*wishes.radius);
  if (wishes.caustic_radius) photon.set_caustic_radius(*wishes.caustic_radius);
  if (wishes.photons) photon.set_photons(*wishes.photons);
  photon.set_map(wishes.map);
  photon.set_light(wishes.light);
  return photon;
}

v1::MetropolisSettings message_of(const MetropolisWishes& wishes) {
  v1::MetropolisSettings metropolis;
  if (wishes.mutations) metropolis.set_mutations(*wishes.mutations);
  if (wishes.candidates) metropolis.set_candidates(*wishes.candidates);
  if (wishes.large_steps) metropolis.set_large_steps(*wishes.large_steps);
  if (wishes.step) metropolis.set_step(*wishes.step);
  return metropolis;
}

v1::RadiositySettings message_of(const RadiosityWishes& wishes) {
  v1::RadiositySettings radiosity;
  if (wishes.error_bound) radiosity.set_error_bound(*wishes.error_bound);
  if (wishes.smallest_area) radiosity.set_smallest_area(*wishes.smallest_area);
  if (wishes.residual) radiosity.set_residual(*wishes.residual);
  if (wishes.final_gather) radiosity.set_final_gather(*wishes.final_gather);
  if (wishes.ignore_non_diffuse) radiosity.set_ignore_non_diffuse(true);
  if (wishes.memory_limit) radiosity.set_memory_limit(*wishes.memory_limit);
  return radiosity;
}

v1::IrradianceCache message_of(const CacheWishes& wishes) {
  v1::IrradianceCache cache;
  if (wishes.error) cache.set_error(*wishes.error);
  if (wishes.samples) cache.set_samples(*wishes.samples);
  if (wishes.reach) cache.set_least_reach(wishes.reach->first);
  if (wishes.reach) cache.set_most_reach(wishes.reach->second);
  cache.set_view(wishes.view);
  if (wishes.glossy_bands) cache.set_glossy_bands(*wishes.glossy_bands);
  return cache;
}

v1::PreviewSettings message_of(const PreviewWishes& wishes) {
  v1::PreviewSettings preview;
  preview.set_shadows(wishes.shadows);
  if (wishes.ambient) preview.set_ambient(*wishes.ambient);
  return preview;
}

bool says_something(const google::protobuf::Message& message) { return message.ByteSizeLong() > 0; }

}  // namespace

v1::RenderSettings OwnWishes::message() const {
  v1::RenderSettings all;
  if (const auto asked = message_of(photon); says_something(asked)) *all.mutable_photon() = asked;
  if (const auto asked = message_of(metropolis); says_something(asked)) *all.mutable_metropolis() = asked;
  if (const auto asked = message_of(radiosity); says_something(asked)) *all.mutable_radiosity() = asked;
  if (const auto asked = message_of(cache); says_something(asked)) *all.mutable_irradiance_cache() = asked;
  if (const auto asked = message_of(preview); says_something(asked)) *all.mutable_preview() = asked;
  if (occlusion_distance) all.mutable_ambient_occlusion()->set_distance(*occlusion_distance);
  if (guiding_samples) all.mutable_guiding()->set_samples(*guiding_samples);
  return all;
}

}  // namespace tessera::client
