#include "import/mitsuba/integrator.h"

#include <algorithm>

#include "import/input/concat.h"
#include "import/mitsuba/document/property_reader.h"
#include "wire/limits.h"

namespace tessera::client::mitsuba {
namespace {

constexpr std::uint32_t kUnlimited = wire::kMaxDepth;

/// The integrator inside of those that only make more images than one.
Object* innermost(Context& context, Object* integrator) {
  while (integrator != nullptr && (integrator->type == "moment" || integrator->type == "aov")) {
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

}  // namespace

void write_integrator(Context& context, Object* integrator) {
  v1::RenderSettings& settings = *context.scene.mutable_settings();
  settings.set_integrator("path");
  settings.set_max_depth(kUnlimited);
  integrator = innermost(context, integrator);
  if (integrator == nullptr) return;
  PropertyReader reader(context, *integrator);
  const std::string& type = integrator->type;
  if (type == "direct") {
    settings.set_integrator("direct");
    settings.set_max_depth(1);
    reader.ignore({"shading_samples", "emitter_samples", "bsdf_samples"});
  } else if (type == "path" || type == "volpath" || type == "volpathmis" || type == "ptracer") {
    settings.set_integrator(type == "path" ? "path" : type == "ptracer" ? "light" : "volpath");
    settings.set_max_depth(read_max_depth(reader));
  } else {
    reader.error(
        concat("integrator \"", type,
               "\" is not supported: expected path, direct, volpath, volpathmis, ptracer, moment or aov"));
    return;
  }
  if (reader.boolean("hide_emitters", false))
    reader.warn("hide_emitters is not supported: lights are seen directly");
  // These steer how samples are spent.
  reader.ignore(
      {"rr_depth", "samples_per_pass", "samples_per_wavefront", "block_size", "timeout", "use_spectral_mis"});
}

}  // namespace tessera::client::mitsuba
