#include "wire/lens_message.h"

#include <cmath>
#include <limits>

#include "absl/strings/str_cat.h"
#include "wire/dispersion.h"
#include "wire/film_format.h"

namespace tessera::wire {

namespace {

void write_dispersion(const spectra::Dispersion& formula, v1::Dispersion& message) {
  const std::string name(formula.name);
  if (!name.empty() && spectra::find_dispersion(name)) {
    message.set_glass(name);
    return;
  }
  v1::Dispersion::Cauchy& cauchy = *message.mutable_cauchy();
  for (const auto& term : formula.terms) {
    if (term.c == 0) cauchy.set_a(cauchy.a() + term.b);
    if (term.c == 2) cauchy.set_b(cauchy.b() + term.b);
    if (term.c == 4) cauchy.set_c(cauchy.c() + term.b);
  }
}

}  // namespace

optics::Prescription prescription_of(const v1::LensPrescription& message,
                                     std::vector<optics::Fault>& faults) {
  optics::Prescription lens{message.name(), message.source(), {}};
  for (const v1::LensSurface& from : message.surfaces()) {
    optics::Surface& to = lens.surfaces.emplace_back();
    to.radius = from.radius_mm(), to.thickness = from.thickness_mm(), to.diameter = from.diameter_mm();
    to.conic = from.conic();
    to.aspheric.assign(from.aspheric().begin(), from.aspheric().end());
    to.cylindrical = from.cylindrical(), to.axis_degrees = from.axis_degrees();
    to.stop = from.stop();
    if (from.has_coating()) to.coating = {from.coating().index(), from.coating().thickness_nm()};
    if (from.has_index()) to.behind.index = from.index();
    if (!from.has_dispersion()) continue;
    if (auto formula = dispersion_of(from.dispersion()); formula.ok()) {
      to.behind.dispersion = *std::move(formula);
    } else {
      faults.push_back(
          {0, 0,
           absl::StrCat("surface ", lens.surfaces.size(), ": ", std::string(formula.status().message())),
           lens.surfaces.size()});
    }
  }
  return lens;
}

void write_prescription(const optics::Prescription& lens, v1::LensPrescription& message) {
  message.set_name(lens.name);
  message.set_source(lens.source);
  for (const optics::Surface& from : lens.surfaces) {
    v1::LensSurface& to = *message.add_surfaces();
    to.set_radius_mm(from.radius);
    to.set_thickness_mm(from.thickness);
    to.set_diameter_mm(from.diameter);
    to.set_conic(from.conic);
    to.mutable_aspheric()->Add(from.aspheric.begin(), from.aspheric.end());
    to.set_cylindrical(from.cylindrical);
    to.set_axis_degrees(from.axis_degrees);
    to.set_stop(from.stop);
    if (from.coating) {
      to.mutable_coating()->set_index(from.coating->index);
      to.mutable_coating()->set_thickness_nm(from.coating->thickness_nm);
    }
    if (from.behind.dispersion) {
      write_dispersion(*from.behind.dispersion, *to.mutable_dispersion());
    } else if (from.behind.index != 1) {
      to.set_index(from.behind.index);
    }
  }
}

double mm_per_unit(const v1::LensCamera& camera) {
  return camera.units_per_mm() > 0 ? 1 / camera.units_per_mm() : 1000;
}

LensFaultPlace place_of(const optics::Fault& fault, const v1::LensCamera& camera) {
  if (fault.surface > 0 && static_cast<int>(fault.surface) <= camera.lens().surfaces_size())
    return {&camera.lens().surfaces(static_cast<int>(fault.surface) - 1)};
  // Members of LensUse have the names of the camera's fields, or nearly so.
  const std::string name = fault.use;
  const auto* const field =
      v1::LensCamera::descriptor()->FindFieldByName(name == "focus"           ? "focus_distance"
                                                    : name == "stop_diameter" ? "stop_diameter_mm"
                                                                              : name);
  return {&camera, field == nullptr ? 0 : field->number()};
}

std::optional<optics::LensSystem> lens_system_of(const v1::LensCamera& camera,
                                                 std::vector<optics::Fault>& faults) {
  const std::size_t before = faults.size();
  const auto is_size = [](double x) { return x >= 0 && std::isfinite(x); };
  const optics::Prescription lens = prescription_of(camera.lens(), faults);
  const auto fault = [&](const char* field, std::string message) {
    faults.push_back({.message = std::move(message), .use = field});
  };
  if (auto of_film = film_fault(camera.film_diagonal_mm(), camera.film_gauge()))
    fault(camera.film_gauge().empty() ? "film_diagonal_mm" : "film_gauge", *std::move(of_film));
  if (!is_size(camera.units_per_mm()))
    fault("units_per_mm", absl::StrCat("a millimetre is not ", camera.units_per_mm(), " units of the scene"));
  if (!is_size(camera.focus_distance()))
    fault("focus_distance", absl::StrCat("a focus at a distance of ", camera.focus_distance()));
  if (camera.has_blades() && camera.blades() < 3)
    fault("blades", absl::StrCat("a stop has 3 to 64 blades, not ", camera.blades()));
  if (camera.has_blades() && camera.has_stop_image())
    fault("stop_image", "a stop's blades and its image exclude each other");
  if (faults.size() > before) return std::nullopt;
  optics::LensUse use;
  if (camera.focus_distance() > 0) use.focus = camera.focus_distance() * mm_per_unit(camera);
  use.f_number = camera.f_number();
  use.stop_diameter = camera.stop_diameter_mm();
  use.blades = static_cast<int>(std::min(camera.blades(), 1000u));
  use.blade_degrees = camera.blade_degrees();
  return optics::LensSystem::focus(lens, use, faults);
}

}  // namespace tessera::wire
