#include "import/pbrt/realistic_camera.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "import/input/concat.h"
#include "import/input/input_file.h"
#include "import/pbrt/aperture_picture.h"
#include "optics/lens_system.h"
#include "optics/read/pbrt_lens_file.h"
#include "wire/lens_message.h"

namespace tessera::client::pbrt {
namespace {

constexpr double kUnitsPerMm = 0.001;  // pbrt's scenes are in metres

void report(Context& context, const std::vector<optics::Fault>& faults, std::uint32_t file,
            SourceLocation camera) {
  for (const optics::Fault& fault : faults) {
    const bool in_file = fault.line > 0;
    context.diagnostics.error(in_file ? SourceLocation{file, static_cast<std::uint32_t>(fault.line),
                                                       static_cast<std::uint32_t>(fault.column)}
                                      : camera,
                              concat(in_file ? "" : "lens: ", fault.message));
  }
}

/// The stop's diameter that a scene asks for; as pbrt-v4 does, not larger than that of the file.
double read_stop(Context& context, ParameterList& parameters, const optics::Prescription& lens) {
  const double wanted = parameters.get_float("aperturediameter", 1, context.diagnostics);
  const auto stop = std::find_if(lens.surfaces.begin(), lens.surfaces.end(),
                                 [](const optics::Surface& surface) { return surface.stop; });
  if (stop == lens.surfaces.end() || wanted <= stop->diameter) return wanted;
  context.diagnostics.warning(parameters.where(),
                              concat("\"aperturediameter\" ", wanted, " is larger than the lens's stop of ",
                                     stop->diameter, " mm, which is used"));
  return stop->diameter;
}

}  // namespace

void write_realistic_camera(Context& context, Directive& camera, Directive& film) {
  Diagnostics& diagnostics = context.diagnostics;
  ParameterList& parameters = camera.parameters;
  v1::LensCamera& message = *context.scene.mutable_camera()->mutable_lens();
  const double focus = parameters.get_float("focusdistance", 10, diagnostics);
  message.set_focus_distance(focus);
  message.set_film_diagonal_mm(film.parameters.get_float("diagonal", 35, diagnostics));
  message.set_units_per_mm(kUnitsPerMm);
  message.set_brightness(v1::LensCamera::IRRADIANCE);
  if (const std::string shape = parameters.get_string("aperture", "", diagnostics);
      !shape.empty() && shape != "circular")
    *message.mutable_stop_image() = aperture_picture(context, shape, parameters.where());
  if (!(focus > 0) || !std::isfinite(focus))
    diagnostics.error(parameters.where(), concat("\"focusdistance\" ", focus, " is not above 0"));
  if (!(message.film_diagonal_mm() > 0))
    diagnostics.error(film.parameters.where(),
                      concat("\"diagonal\" ", message.film_diagonal_mm(), " of the film is not above 0"));

  const std::string name = parameters.get_string("lensfile", "", diagnostics);
  if (name.empty()) {
    diagnostics.error(parameters.where(), "camera \"realistic\" needs a \"lensfile\"");
    return;
  }
  const absl::StatusOr<InputFile> file = InputFile::open(context.resolve(name));
  if (!file.ok()) {
    diagnostics.error(parameters.where(), concat("lensfile: ", std::string(file.status().message())));
    return;
  }
  const std::uint32_t number = diagnostics.add_file(context.resolve(name).string());
  std::vector<optics::Fault> faults;
  const optics::Prescription lens = optics::read_pbrt_lens(file->bytes(), faults);
  message.set_stop_diameter_mm(read_stop(context, parameters, lens));
  if (!(message.stop_diameter_mm() > 0))
    diagnostics.error(parameters.where(),
                      concat("\"aperturediameter\" ", message.stop_diameter_mm(), " is not above 0"));
  if (faults.empty() && !diagnostics.has_errors()) {
    optics::LensUse use;
    use.focus = focus / kUnitsPerMm;
    use.stop_diameter = message.stop_diameter_mm();
    optics::LensSystem::focus(lens, use, faults);
  }
  report(context, faults, number, parameters.where());
  wire::write_prescription(lens, *message.mutable_lens());
}

}  // namespace tessera::client::pbrt
