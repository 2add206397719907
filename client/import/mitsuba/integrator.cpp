#include "import/mitsuba/integrator.h"

#include <algorithm>
#include <iterator>
#include <optional>
#include <string_view>

#include "import/input/concat.h"
#include "import/input/integrator_choice.h"
#include "import/mitsuba/document/property_reader.h"
#include "wire/limits.h"
#include "wire/settings.h"

namespace tessera::client::mitsuba {
namespace {

constexpr std::uint32_t kUnlimited = wire::kMaxDepth;

// The names of Mitsuba 3 and 0.6.
constexpr IntegratorName kIntegrators[] = {
    {"path", "path", "path"},
    {"volpath", "volpath", "volpath"},
    {"volpathmis", "volpath", "volpath"},
    {"volpath_simple", "volpath", "volpath"},
    {"direct", "direct", "direct"},
    {"ptracer", "light", "path"},
    {"bdpt", "bdpt", "volpath", true},
    {"pssmlt", "mlt", "volpath", true},
    {"mlt", "mlt", "volpath", true},
    {"erpt", "mlt", "volpath", true},
    {"photonmapper", "photon", "volpath", true},
    {"ppm", "photon", "path"},
    {"sppm", "photon", "path"},
    {"irrcache", "irradiance-cache", "path"},
    {"ao", "ao", "path"},
    // These differentiate the pictures of others.
    {"prb", "path", "path"},
    {"prb_basic", "path", "path"},
    {"prbvolpath", "volpath", "volpath"},
};

/// Integrators that only make more images of one inside of them, or spend its samples otherwise.
constexpr std::string_view kWrappers[] = {"moment", "aov", "stokes", "adaptive"};

/// The integrator inside of such ones.
Object* innermost(Context& context, Object* integrator) {
  const auto wraps = [](const Object& object) {
    return std::ranges::find(kWrappers, object.type) != std::end(kWrappers);
  };
  while (integrator != nullptr && wraps(*integrator)) {
    PropertyReader reader(context, *integrator);
    Object* nested = reader.child("integrator");
    if (nested == nullptr) reader.error(concat(integrator->title(), ": expected an integrator inside"));
    if (integrator->type == "aov") {
      reader.warn("the images that integrator \"aov\" asks for are left out: use --aov");
      reader.ignore({"aovs"});
    }
    integrator = nested;
  }
  return integrator;
}

/// Mitsuba counts the segments of a path from the camera, and here its scattering events.
std::uint32_t read_max_depth(PropertyReader& reader) {
  const std::int64_t segments = reader.integer("max_depth", -1);
  if (segments < -1) reader.error(*reader.find("max_depth"), concat("expected -1 or more, found ", segments));
  if (segments < 0) return kUnlimited;
  if (segments == 0) reader.warn("max_depth 0 would be a black image: what is seen directly is kept");
  return static_cast<std::uint32_t>(std::clamp<std::int64_t>(segments - 1, 0, kUnlimited));
}

/// Parameters that do not change what the picture shows, or that only algorithms have which others stand in
/// for.
void ignore_how_samples_are_spent(PropertyReader& reader) {
  reader.ignore({"rr_depth",
                 "samples_per_pass",
                 "samples_per_wavefront",
                 "block_size",
                 "timeout",
                 "use_spectral_mis",
                 "shading_samples",
                 "emitter_samples",
                 "bsdf_samples",
                 "light_image",
                 "sample_direct",
                 "direct_samples",
                 "luminance_samples",
                 "two_stage",
                 "bidirectional",
                 "caustic_photons",
                 "volume_photons",
                 "lookup_size",
                 "granularity",
                 "max_passes",
                 "resolution",
                 "quality",
                 "max_error",
                 "p_value",
                 "max_sample_factor",
                 "bidirectional_mutation",
                 "lens_perturbation",
                 "multi_chain_perturbation",
                 "caustic_perturbation",
                 "manifold_perturbation",
                 "alpha"});
}

/// Settings of photons, which other integrators leave alone. A radius of 0 is Mitsuba's for one that follows
/// from the scene's size.
void write_photons(PropertyReader& reader, v1::RenderSettings& settings) {
  for (const char* name : {"photon_count", "global_photons"}) {
    const std::int64_t photons = reader.integer(name, 0);
    if (photons > 0)
      settings.mutable_photon()->set_photons(
          static_cast<std::uint64_t>(wire::within_bounds("photon.photons", static_cast<double>(photons))));
  }
  if (const double radius = reader.number("initial_radius", 0); radius > 0)
    settings.mutable_photon()->set_radius(wire::within_bounds("photon.radius", radius));
  if (reader.has("global_lookup_radius") || reader.has("caustic_lookup_radius")) {
    reader.warn(
        "lookup radii in parts of the scene's size are not supported: --set "
        "photon.radius and photon.caustic-radius set them");
    reader.ignore({"global_lookup_radius", "caustic_lookup_radius"});
  }
}

}  // namespace

void write_integrator(Context& context, Object* integrator) {
  v1::RenderSettings& settings = *context.scene.mutable_settings();
  settings.set_integrator("path");
  settings.set_max_depth(kUnlimited);
  integrator = innermost(context, integrator);
  if (integrator == nullptr) return;
  PropertyReader reader(context, *integrator);
  const std::string& type = integrator->type;
  std::optional<IntegratorName> asked = find_integrator(kIntegrators, type);
  if (type == "depth") {
    reader.warn("integrator \"depth\" is a layer here: use --aov depth; 'path' renders the scene");
    asked = find_integrator(kIntegrators, "path");
  }
  if (!asked) {
    reader.error(concat("integrator \"", type, "\" is not supported: expected ", list_of(kIntegrators),
                        ", moment, aov, stokes, adaptive or depth"));
    return;
  }
  const IntegratorChoice choice = choose_integrator(*asked, context.scene);
  if (!choice.warning.empty()) reader.warn(choice.warning);
  settings.set_integrator(choice.name);
  if (const double length = reader.number("ray_length", -1); length > 0)
    settings.mutable_ao()->set_distance(length);
  if (const double large = reader.number("p_large", 0); large > 0)
    settings.mutable_mlt()->set_large_steps(wire::within_bounds("mlt.large-steps", large));
  write_photons(reader, settings);
  if (type == "direct") {
    settings.set_max_depth(1);
  } else if (Object* const nested = reader.child("integrator"); nested != nullptr) {
    PropertyReader inner(context, *nested);
    settings.set_max_depth(read_max_depth(inner));
    ignore_how_samples_are_spent(inner);
  } else {
    settings.set_max_depth(read_max_depth(reader));
  }
  if (reader.boolean("hide_emitters", false))
    reader.warn("hide_emitters is not supported: lights are seen directly");
  ignore_how_samples_are_spent(reader);
}

}  // namespace tessera::client::mitsuba
