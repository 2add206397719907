#include "import/pbrt/render_settings.h"

#include <algorithm>
#include <iterator>
#include <limits>

#include "import/input/concat.h"
#include "import/pbrt/file/tokenizer.h"
#include "wire/limits.h"

namespace tessera::client::pbrt {
namespace {

constexpr std::int64_t kLargest = std::numeric_limits<std::int32_t>::max();

template <std::size_t N>
bool contains(const std::string_view (&names)[N], std::string_view name) {
  return std::find(std::begin(names), std::end(names), name) != std::end(names);
}

struct IntegratorType {
  std::string_view name;
  const char* ours;
  bool same_image;  // once converged
};

constexpr IntegratorType kIntegrators[] = {{"path", "path", true},        {"simplepath", "path", true},
                                           {"volpath", "volpath", true},  {"simplevolpath", "volpath", true},
                                           {"bdpt", "volpath", true},     {"mlt", "volpath", true},
                                           {"sppm", "volpath", true},     {"lightpath", "light", true},
                                           {"ao", "volpath", false},      {"randomwalk", "volpath", true},
                                           {"function", "volpath", false}};

constexpr std::string_view kSamplers[] = {"independent", "sobol",   "paddedsobol", "zsobol",
                                          "halton",      "pmj02bn", "stratified"};

}  // namespace

void write_integrator(Context& context, Directive& integrator) {
  Diagnostics& diagnostics = context.diagnostics;
  ParameterList& parameters = integrator.parameters;
  const auto known = std::find_if(std::begin(kIntegrators), std::end(kIntegrators),
                                  [&](const IntegratorType& type) { return type.name == integrator.type; });
  if (known == std::end(kIntegrators)) {
    diagnostics.error(parameters.where(),
                      concat("unknown integrator \"", integrator.type,
                             "\": expected path, volpath, simplepath, simplevolpath, bdpt, mlt, "
                             "sppm, lightpath, ao or randomwalk"));
    return;
  }
  if (!known->same_image) {
    diagnostics.warning(parameters.where(),
                        concat("integrator \"", integrator.type,
                               "\" is not supported: \"volpath\" shows the scene's light instead"));
  }
  v1::RenderSettings& settings = *context.scene.mutable_settings();
  settings.set_integrator(known->ours);
  const std::int64_t depth = parameters.get_integer("maxdepth", 5, diagnostics);
  settings.set_max_depth(static_cast<std::uint32_t>(std::clamp<std::int64_t>(depth, 0, wire::kMaxDepth)));
  if (parameters.get_bool("regularize", false, diagnostics)) {
    diagnostics.warning(parameters.where(),
                        "\"regularize\" of the integrator is not applied: the image stays unbiased");
  }
  // How samples are spent, not what the image shows; and what belongs to the algorithms that "volpath" stands
  // in for.
  parameters.ignore({"lightsampler",
                     "lightsampling",
                     "bsdfsampling",
                     "samplelights",
                     "samplebsdf",
                     "visualizestrategies",
                     "visualizeweights",
                     "photonsperiteration",
                     "radius",
                     "seed",
                     "bootstrapsamples",
                     "chains",
                     "mutationsperpixel",
                     "largestepprobability",
                     "sigma",
                     "cossample",
                     "maxdistance",
                     "function",
                     "filename",
                     "skipbad",
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
  // These do not change what the image shows.
  constexpr std::string_view kWithoutEffect[] = {
      "rendercoordsys",          "pixelstats",           "wavefront", "msereferenceimage", "msereferenceout",
      "disabletexturefiltering", "displacementedgescale"};
  if (contains(kWithoutEffect, name) || value == "false") return;
  context.diagnostics.warning(where, concat("option \"", name, "\" is not supported: it is ignored"));
}

}  // namespace tessera::client::pbrt
