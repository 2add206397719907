#include "measure/lamp_file_of.h"

#include <cmath>
#include <cstddef>

#include "absl/strings/str_cat.h"
#include "measure/fault.h"

namespace tessera::client {

absl::StatusOr<photometry::Luminaire> luminaire_of(const v1::Meter& meter, const MeasuredMeter& measured) {
  if (!meter.has_intensity() || measured.unit != "cd")
    return fault(absl::StrCat("meter '", measured.name, "' is none of intensity in cd"));
  const double gamma_step =
      meter.intensity().gamma_step_degrees() > 0 ? meter.intensity().gamma_step_degrees() : 5;
  const double c_step = meter.intensity().c_step_degrees() > 0 ? meter.intensity().c_step_degrees() : 15;
  photometry::Luminaire luminaire;
  luminaire.labels = {{"TEST", "tessera measure"}, {"LUMINAIRE", measured.name}};
  luminaire.ies_year = 2019;
  for (double c = 0; c < 360 - 1e-9; c += c_step) luminaire.plane_degrees.push_back(c);
  for (double gamma = 0; gamma <= 180 + 1e-9; gamma += gamma_step) luminaire.polar_degrees.push_back(gamma);
  const std::size_t directions = luminaire.plane_degrees.size() * luminaire.polar_degrees.size();
  if (measured.readings.size() != directions) return fault("an intensity meter lacks directions");
  for (const Reading& reading : measured.readings) {
    if (!(reading.figure.value >= 0)) return fault("an intensity is negative");
    luminaire.values.push_back(reading.figure.value);
  }
  if (const std::string why = photometry::fault_of(luminaire); !why.empty())
    return fault(absl::StrCat("meter '", measured.name, "': ", why));
  return luminaire;
}

}  // namespace tessera::client
