#include "command/own_options.h"

#include <optional>

#include "command/jobs/job_settings.h"
#include "command/read_option.h"
#include "wire/limits.h"
#include "wire/scene_numbers.h"

namespace tessera::client {
namespace {

void define_photon_options(options::Command& command, PhotonWishes& photon) {
  command.group("Integrator photon");
  command
      .add("--photon-radius", photon.radius,
           "radius of the first pass's estimates, in the scene's units; usually 3 pixels on what is seen")
      .in_range(wire::kMinPhotonRadius, wire::kMaxPhotonRadius)
      .type_name("R");
  command
      .add("--photon-caustic-radius", photon.caustic_radius,
           "the same for caustics, which have a map of their own; the same radius unless given")
      .in_range(wire::kMinPhotonRadius, wire::kMaxPhotonRadius)
      .type_name("R");
  command.add("--photons", photon.photons, "light paths of a pass; usually the film's pixels, up to 2^20")
      .in_range(1, wire::kMaxPhotons);
  add_word(command, "--photon-map", photon.map,
           "progressive (a radius that shrinks) or classic (one map for all passes; biased)");
  add_word(command, "--photon-light", photon.light,
           "light that photons bring: indirect (lights are sampled) or all");
}

void define_metropolis_options(options::Command& command, MetropolisWishes& wishes) {
  command.group("Integrator mlt");
  command.add("--mutations", wishes.mutations, "mutations of a chain; 128 unless given")
      .in_range(1, wire::kMaxMutations);
  command
      .add("--candidates", wishes.candidates, "paths of its own for each chain to begin at; 32 unless given")
      .in_range(1, wire::kMaxCandidates);
  command
      .add("--large-steps", wishes.large_steps,
           "probability that a mutation is a path that is all new; 0.3 unless given")
      .in_range(wire::kMinLargeSteps, 1)
      .type_name("P");
  command
      .add("--mutation-step", wishes.step,
           "largest step of the others, of the unit interval of each random number; 1/32 unless given")
      .in_range(wire::kMinStep, wire::kMaxStep)
      .type_name("X");
}

void define_cache_options(options::Command& command, CacheWishes& cache) {
  command.group("Integrator irradiance-cache");
  command
      .add("--cache-error", cache.error,
           "largest error of a record where it is used, as Ward estimates it (0.3 unless given)")
      .in_range(wire::kLeastCacheError, wire::kMostCacheError);
  command.add("--cache-samples", cache.samples, "rays of a record (1024 unless given)")
      .in_range(wire::kLeastCacheSamples, wire::kMostCacheSamples);
  add_parsed(command, "--cache-reach", cache.reach, parse_reach,
             "how far records reach, in widths of a pixel (3,32 unless given)")
      .type_name("MIN,MAX");
  command
      .add("--cache-glossy", cache.glossy_bands,
           "bands of spherical harmonics of records at glossy surfaces, from 2 on; 0: these have no records "
           "(8 "
           "unless given)")
      .in_range(0u, wire::kMostGlossyBands);
  command.add_flag("--cache-view", cache.view, "show a red point at each record");
}

void define_preview_options(options::Command& command, PreviewWishes& preview) {
  command.group("Integrator preview");
  add_word(command, "--shadows", preview.shadows,
           "shadows: pcss (as soft as the lamp is large), pcf, hard or none");
  command.add("--ambient", preview.ambient, "factor of ambient light; 1 unless given")
      .in_range(0, wire::kMaxAmbient);
}

void define_occlusion_options(options::Command& command, std::optional<double>& distance) {
  command.group("Integrator ao");
  command.add("--ao-distance", distance, "how far things hide the sky, in units of the scene; 0: however far")
      .in_range(0, wire::kLargestSceneNumber);
}

void define_guiding_options(options::Command& command, std::optional<double>& samples) {
  command.group("Integrator guided");
  command
      .add("--guiding-samples", samples,
           "paths a pixel that are learned from and are none of the picture (3.5 unless given)")
      .in_range(wire::kLeastGuidingSamples, wire::kMostGuidingSamples)
      .type_name("N");
}

}  // namespace

void define_radiosity_options(options::Command& command, RadiosityWishes& radiosity) {
  command.group("Integrator radiosity");
  command
      .add("--radiosity-error", radiosity.error_bound,
           "error of a link's light, over the mean irradiance (0.01 unless given)")
      .in_range(1e-6, 1)
      .type_name("X");
  command
      .add("--smallest-patch", radiosity.smallest_area,
           "area, scene units squared, below which patches are not split (usually 1/50,000 of all surfaces)")
      .in_range(0, 1e30)
      .type_name("AREA");
  command
      .add("--radiosity-residual", radiosity.residual,
           "power that the last sweep moves, over all power (0.0001 unless given)")
      .in_range(1e-12, 1)
      .type_name("X");
  add_parsed(command, "--final-gather", radiosity.final_gather, parse_switch,
             "on: the patches light what is seen; off: they are what is seen")
      .type_name("on|off");
  command.add_flag("--ignore-non-diffuse", radiosity.ignore_non_diffuse,
                   "leave out of materials what is not diffuse");
  add_parsed(command, "--memory-limit", radiosity.memory_limit, parse_bytes,
             "memory for patches and links (4G unless given)")
      .type_name("SIZE");
}

void define_own_options(options::Command& command, OwnWishes& own) {
  define_photon_options(command, own.photon);
  define_metropolis_options(command, own.metropolis);
  define_radiosity_options(command, own.radiosity);
  define_cache_options(command, own.cache);
  define_preview_options(command, own.preview);
  define_occlusion_options(command, own.occlusion_distance);
  define_guiding_options(command, own.guiding_samples);
}

}  // namespace tessera::client
