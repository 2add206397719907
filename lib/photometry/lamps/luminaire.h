// Light of a luminaire by direction, as goniophotometers measure it and photometric files hold it.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace tessera::photometry {

/// Systems of planes in which intensities are measured [CIE 121-1996; LM-63-19]. Space of the luminaire: -z
/// is gamma 0 of C planes (mostly downward) and the axis of the beam of A and B planes, +x is plane C0 and
/// the positive side of horizontal angles, +y is plane C90 and the positive side of vertical angles.
enum class PlaneSystem {
  kC,  // planes about the z axis by angle C; in each, gamma from -z (0) to +z (180)
  kB,  // planes about the x axis by vertical angle; in each, horizontal angles from -90 to 90
  kA   // planes about the y axis by horizontal angle; in each, vertical angles from -90 to 90
};

/// Light of a lamp that is tilted, over that of the same lamp upright.
struct LampTilt {
  std::string file;  // where it stands, if not in the file of the luminaire
  int geometry = 1;  // of lamp and luminaire: 1 vertical, 2 and 3 horizontal
  std::vector<double> degrees, factors;

  bool empty() const { return file.empty() && degrees.empty(); }
  bool operator==(const LampTilt&) const = default;
};

/// A standard set of lamps, which the luminaire may be used with [EULUMDAT].
struct LampSet {
  int count = 1;
  std::string type;
  double lumens = 0;  // of all of them together
  std::string color, rendering;
  double watts = 0;
  bool operator==(const LampSet&) const = default;
};

/// Fields that EULUMDAT has and IES files do not.
struct EulumdatFields {
  int type = 1;      // 1: a point with symmetry about the vertical axis, 2: linear, 3: other points
  int symmetry = 0;  // 0: none; 1: about the axis; 2: to plane C0-C180; 3: to C90-C270; 4: to both
  double c_step = 0, gamma_step = 0;
  double luminous_length = 0, luminous_width = 0;                    // mm
  double luminous_heights[4] = {0, 0, 0, 0};                         // mm, at C0, C90, C180 and C270
  double downward_flux_percent = 0, light_output_ratio_percent = 0;  // as the file says
  double tilt_degrees = 0;                                           // during the measurement
  std::vector<LampSet> sets;
  double direct_ratios[10] =
      {};  // for room indices 0.60, 0.80, 1.00, 1.25, 1.50, 2.00, 2.50, 3.00, 4.00, 5.00
  std::vector<double> c_degrees;  // all planes, of which intensities of some stand in the file

  bool operator==(const EulumdatFields&) const = default;
};

struct Luminaire {
  /// Lines of the file about it: "MANUFAC", "LUMCAT", "LUMINAIRE", "LAMP", "TEST", "ISSUEDATE" and others as
  /// IES files call them, in order, with the lines of each; "" for text without a keyword.
  std::vector<std::pair<std::string, std::string>> labels;

  PlaneSystem system = PlaneSystem::kC;
  /// Planes by ascending angle. C: 0 alone (the same in all), 0 to 90, 0 to 180, 90 to 270, or all around,
  /// with or without 360. A and B: 0 to 90 (the same on both sides) or -90 to 90, or parts of these.
  std::vector<double> plane_degrees;
  /// Directions within a plane, ascending; no light leaves in others. A and B: from 0 the same on both sides.
  std::vector<double> polar_degrees;
  /// The file's own numbers, [plane][polar angle].
  std::vector<double> values;

  int lamps = 1;
  double lumens_per_lamp = -1;  // below 0: photometry is absolute
  double multiplier = 1;        // of values
  double ballast_factor = 1;
  double lamp_ballast_factor = 1;  // files of 1995 and before
  double file_generation = 1;      // files of 2019: how the figures came about
  double watts = 0;
  // IES: of the luminous opening; below 0: round. EULUMDAT: of the luminaire, in mm.
  double width = 0, length = 0, height = 0;
  bool feet = false;  // their unit in IES files; else metres
  LampTilt tilt;
  int ies_year = 0;  // of the standard of an IES file: 1986, 1991, 1995, 2002, 2019; 0: it came from none
  EulumdatFields eulumdat;
  double eulumdat_factor = 1;  // "conversion factor for luminous intensities"
  bool is_eulumdat = false;    // values are cd/klm

  /// Candelas of one of `values`.
  double candelas_per_value() const;
  double candelas(std::size_t plane, std::size_t polar) const {
    return values[plane * polar_degrees.size() + polar] * candelas_per_value();
  }
  bool is_absolute() const { return lumens_per_lamp < 0; }
  /// Flux of all lamps, lm; 0 where photometry is absolute.
  double lamp_lumens() const { return is_absolute() ? 0 : lamps * lumens_per_lamp; }
  bool operator==(const Luminaire&) const = default;
};

/// A direction of the luminaire's space, as angles of a plane and within it, in degrees: C from 0 to 360 and
/// gamma from 0 to 180, or from -180 to 180 and from -90 to 90.
struct PlaneAngles {
  double plane = 0, polar = 0;
};
PlaneAngles angles_of(PlaneSystem system, double x, double y, double z);

/// Luminous intensity in a direction of unit length, cd: linear in both angles between the nearest four of
/// the table, 0 beyond its polar angles (and, of A and B planes, beyond its planes). Needs a sound table
/// (fault_of()).
double intensity(const Luminaire& luminaire, double x, double y, double z);

/// Likewise by angles.
double intensity_at(const Luminaire& luminaire, PlaneAngles at);

/// Total luminous flux, lm: the exact integral of intensity() over all directions.
double flux(const Luminaire& luminaire);

/// Flux into the half-space of -z, lm: of C planes.
double downward_flux(const Luminaire& luminaire);

/// Why the table is none: angles that do not ascend or leave their range, too few values,
/// values that are not finite or negative. Empty where it is sound.
std::string fault_of(const Luminaire& luminaire);

}  // namespace tessera::photometry
