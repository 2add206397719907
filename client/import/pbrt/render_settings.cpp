#include "import/pbrt/render_settings.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>

#include "import/input/concat.h"
#include "import/input/integrator_choice.h"
#include "import/pbrt/file/tokenizer.h"
#include "wire/limits.h"
#include "wire/settings.h"

namespace tessera::client::pbrt {
namespace {

constexpr std::int64_t kLargest = std::numeric_limits<std::int32_t>::max();

template <std::size_t N>
bool contains(const std::string_view (&names)[N], std::string_view name) {
  return std::find(std::begin(names), std::end(names), name) != std::end(names);
}

// The names of versions 3 and 4.
constexpr IntegratorName kIntegrators[] = {
    {"path", "path", "path"},           {"volpath", "volpath", "volpath"},
    {"simplepath", "path", "path"},     {"simplevolpath", "volpath", "volpath"},
    {"bdpt", "bdpt", "volpath", true},  {"mlt", "mlt", "volpath", true},
    {"sppm", "photon", "path"},         {"lightpath", "light", "path"},
    {"randomwalk", "path", "path"},     {"ao", "ao", "path"},
    {"ambientocclusion", "ao", "path"}, {"directlighting", "direct", "direct"},
    {"whitted", "whitted", "whitted"},
};
/// Shows a function instead of the scene.
constexpr std::string_view kFunction = "function";

constexpr std::string_view kSamplers[] = {"independent", "sobol",   "paddedsobol", "zsobol",
                                          "halton",      "pmj02bn", "stratified"};

/// Those of pbrt's parameters of its integrator "mlt" that mean something here, where they are given: how
/// long its chains are follows from their number and the film's size.
void write_metropolis(ParameterList& parameters, Diagnostics& diagnostics, v1::RenderSettings& settings) {
  if (const double large = parameters.get_float("largestepprobability", 0, diagnostics); large > 0)
    settings.mutable_mlt()->set_large_steps(wire::within_bounds("mlt.large-steps", large));
  // Its small steps are normally distributed.
  if (const double sigma = parameters.get_float("sigma", 0, diagnostics); sigma > 0)
    settings.mutable_mlt()->set_step(wire::within_bounds("mlt.step", sigma));
  const std::int64_t chains = std::max<std::int64_t>(parameters.get_integer("chains", 1000, diagnostics), 1);
  if (const std::int64_t paths = parameters.get_integer("bootstrapsamples", 0, diagnostics); paths > 0) {
    settings.mutable_mlt()->set_candidates(static_cast<std::uint32_t>(
        wire::within_bounds("mlt.candidates", static_cast<double>(paths / chains))));
  }
}

/// Settings of photons, which other integrators leave alone. A radius or a number that is not positive is
/// pbrt's for "as is usual".
void write_photons(ParameterList& parameters, v1::RenderSettings& settings, Diagnostics& diagnostics) {
  const double radius = parameters.get_float("radius", 0, diagnostics);
  if (radius > 0) settings.mutable_photon()->set_radius(wire::within_bounds("photon.radius", radius));
  const std::int64_t photons = parameters.get_integer("photonsperiteration", 0, diagnostics);
  if (photons > 0)
    settings.mutable_photon()->set_photons(
        static_cast<std::uint64_t>(wire::within_bounds("photon.photons", static_cast<double>(photons))));
}

}  // namespace

void write_integrator(Context& context, Directive& integrator) {
  Diagnostics& diagnostics = context.diagnostics;
  ParameterList& parameters = integrator.parameters;
  std::optional<IntegratorName> asked = find_integrator(kIntegrators, integrator.type);
  if (integrator.type == kFunction) {
    diagnostics.warning(parameters.where(),
                        "integrator \"function\" is not supported: 'path' shows the scene's light instead");
    asked = find_integrator(kIntegrators, "path");
  }
  if (!asked) {
    diagnostics.error(parameters.where(), concat("unknown integrator \"", integrator.type, "\": expected ",
                                                 list_of(kIntegrators)));
    return;
  }
  const IntegratorChoice choice = choose_integrator(*asked, context.scene);
  if (!choice.warning.empty()) diagnostics.warning(parameters.where(), choice.warning);
  v1::RenderSettings& settings = *context.scene.mutable_settings();
  settings.set_integrator(choice.name);
  // Lights that are not sampled are found by chance, or never.
  const bool samples_lights = parameters.get_bool("samplelights", true, diagnostics);
  if (integrator.type == "randomwalk" || (integrator.type == "simplepath" && !samples_lights))
    settings.set_direct_light(v1::DIRECT_LIGHT_BSDF);
  if (const double distance = parameters.get_float("maxdistance", 0, diagnostics);
      distance > 0 && std::isfinite(distance))
    settings.mutable_ao()->set_distance(distance);
  if (integrator.type == "mlt") write_metropolis(parameters, diagnostics, settings);
  write_photons(parameters, settings, diagnostics);
  const std::int64_t depth = parameters.get_integer("maxdepth", 5, diagnostics);
  settings.set_max_depth(static_cast<std::uint32_t>(std::clamp<std::int64_t>(depth, 0, wire::kMaxDepth)));
  if (parameters.get_bool("regularize", false, diagnostics)) {
    diagnostics.warning(parameters.where(),
                        "\"regularize\" of the integrator is not applied: the image stays unbiased");
  }
  // How samples are spent, not what the image shows; and what belongs to algorithms that others
  // stand in for.
  parameters.ignore({"lightsampler", "lightsampling", "bsdfsampling", "samplebsdf", "visualizestrategies",
                     "visualizeweights", "seed", "bootstrapsamples", "chains", "mutationsperpixel",
                     "largestepprobability", "sigma", "cossample", "function", "filename", "skipbad",
                     "imagefilename"});
}

void write_sampler(Context& context, Directive& sampler) {
  Diagnostics& diagnostics = context.diagnostics;
  ParameterList& parameters = sampler.parameters;
  if (!contains(kSamplers, sampler.type)) {
    diagnostics.error(parameters.where(), concat("unknown sampler \"", sampler.type,
                                                 "\": expected independent, sobol, "
                                                 "paddedsobol, zsobol, halton, pmj02bn or stratified"));
    return;
  }
  // Which sequence pbrt would take says nothing about the picture: Tessera takes its own.
  v1::RenderSettings& settings = *context.scene.mutable_settings();
  std::int64_t spp =
      parameters.get_integer("pixelsamples", sampler.type == "independent" ? 4 : 16, diagnostics);
  if (sampler.type == "stratified") {
    spp = std::clamp<std::int64_t>(parameters.get_integer("xsamples", 4, diagnostics), 1, 1 << 15) *
          std::clamp<std::int64_t>(parameters.get_integer("ysamples", 4, diagnostics), 1, 1 << 15);
  }
  if (spp < 1)
    diagnostics.error(parameters.where(), concat("sampler: ", spp, " samples a pixel are too few"));
  settings.set_spp(static_cast<std::uint32_t>(std::clamp<std::int64_t>(spp, 1, kLargest)));
  const std::int64_t seed = parameters.get_integer("seed", 0, diagnostics);
  if (seed > 0) settings.set_seed(static_cast<std::uint64_t>(seed));
  parameters.ignore({"randomization", "jitter"});
}

void write_option(Context& context, const std::string& name, std::string_view value, SourceLocation where) {
  if (name == "seed") {
    const std::optional<double> seed = parse_number(value);
    if (!seed || *seed < 0) {
      context.diagnostics.error(where, concat("option \"seed\": expected a number, found \"", value, "\""));
    } else {
      context.scene.mutable_settings()->set_seed(static_cast<std::uint64_t>(*seed));
    }
    return;
  }
  if (name == "disabletexturefiltering" && value == "true") {
    context.scene.mutable_settings()->set_texture_footprint(0);
    return;
  }
  // These do not change what the image shows.
  constexpr std::string_view kWithoutEffect[] = {"rendercoordsys",  "pixelstats",
                                                 "wavefront",       "msereferenceimage",
                                                 "msereferenceout", "displacementedgescale"};
  if (contains(kWithoutEffect, name) || value == "false") return;
  context.diagnostics.warning(where, concat("option \"", name, "\" is not supported: it is ignored"));
}

}  // namespace tessera::client::pbrt
