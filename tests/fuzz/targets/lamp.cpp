// Photometric files, IES and EULUMDAT, and what is made of them.
#include <array>
#include <cmath>

#include "fuzz/target.h"
#include "photometry/lamps/lamp_file.h"
#include "photometry/units/light_unit.h"

namespace tessera::fuzz {
namespace {

/// Holds of every luminaire that was read: intensities and flux that are numbers, and files that read back.
void check(const photometry::Luminaire& luminaire) {
  require(photometry::fault_of(luminaire).empty(), "a luminaire with a fault");
  for (const auto& [x, y, z] :
       {std::array{0.0, 0.0, -1.0}, std::array{0.6, 0.0, 0.8}, std::array{-0.48, 0.64, -0.6}}) {
    const double candelas = photometry::intensity(luminaire, x, y, z);
    require(candelas >= 0, "an intensity that is none");
  }
  const double lumens = photometry::flux(luminaire);
  require(!std::isnan(lumens), "a flux that is none");
  const auto written =
      luminaire.is_eulumdat ? photometry::write_eulumdat(luminaire) : photometry::write_ies(luminaire);
  require(written.ok(), "a luminaire that is not written");
  std::vector<std::string> warnings;
  const auto again = luminaire.is_eulumdat ? photometry::read_eulumdat(*written, {.name = "again"}, warnings)
                                           : photometry::read_ies(*written, {.name = "again"}, warnings);
  require(again.ok(), "a file that is not read back");
  require(again->values == luminaire.values && again->polar_degrees == luminaire.polar_degrees &&
              again->plane_degrees == luminaire.plane_degrees,
          "a table that is read back as another");
  const auto twice = again->is_eulumdat ? photometry::write_eulumdat(*again) : photometry::write_ies(*again);
  require(twice.ok() && *twice == *written, "a file that is written back as another");
}

bool accepts_lamp(std::string_view bytes) {
  const std::vector<char> input = exact(bytes);
  const std::string_view text(input.data(), input.size());
  const auto unit = photometry::parse_light_unit(text);
  require(unit.ok() ? unit->factor > 0 : !unit.status().message().empty(), "a unit without a factor");
  static_cast<void>(photometry::parse_length_unit(text).ok());
  std::vector<std::string> warnings;
  const photometry::LampFileOptions options{
      .name = "lamp",
      .tilt_files = [&](const std::string&) -> absl::StatusOr<std::string> { return std::string(text); }};
  const auto luminaire = photometry::read_lamp_file(text, options, warnings);
  for (const std::string& warning : warnings) require(!warning.empty(), "an empty warning");
  if (!luminaire.ok()) {
    require(!luminaire.status().message().empty(), "an error without a message");
    return false;
  }
  photometry::Luminaire kept = *luminaire;
  if (!kept.tilt.degrees.empty()) kept.tilt.file.clear();  // written with its factors
  check(kept);
  return true;
}

}  // namespace

const Target kLamp = {"lamp", accepts_lamp};

}  // namespace tessera::fuzz
