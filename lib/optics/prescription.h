// Lenses as their designers write them down: surfaces in the order in which light from the scene meets them.
// Lengths are in millimetres, wavelengths in nanometres.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "spectra/matter/dispersion.h"

namespace tessera::optics {

/// Where indices of refraction are told that are one number: the Fraunhofer line d.
inline constexpr double kLineD = 587.56;

struct Medium {
  double index = 1;  // of all wavelengths, where there is no formula
  std::optional<spectra::Dispersion> dispersion;

  double eta(double nm) const { return dispersion ? dispersion->eta(nm) : index; }
};

/// One layer on a surface, which reflects less than the bare glass.
struct Coating {
  double index = 1;
  double thickness_nm = 0;
};

struct Surface {
  double radius = 0;             // of curvature; above 0 where its middle lies on the film's side; 0: flat
  double thickness = 0;          // along the axis to the next surface
  double diameter = 0;           // clear aperture
  Medium behind;                 // on the film's side
  double conic = 0;              // constant: -1 is a paraboloid
  std::vector<double> aspheric;  // coefficients of height^4, height^6, ...
  bool cylindrical = false;
  double axis_degrees = 0;  // direction in which a cylinder is straight, from x towards y
  bool stop = false;
  std::optional<Coating> coating;
  int line = 0;  // of the file that it was read from; 0: none
};

/// The least aperture that a surface or a stop may have, in mm.
inline constexpr double kLeastDiameter = 1e-3;

struct Prescription {
  std::string name, source;
  std::vector<Surface> surfaces;
};

/// Something that is wrong with a prescription, or with a file that has one.
struct Fault {
  int line = 0, column = 0;  // of the file, from 1; 0: not known
  std::string message;
  std::size_t surface = 0;  // from 1; 0: none of them
  const char* use = "";     // name of the member of LensUse that is at fault; empty: none of them
};

/// Height above the plane of the vertex, on the film's side of it above 0, at this distance from the axis (of
/// a cylinder, across it); nothing beyond where the surface ends.
std::optional<double> sag(const Surface& surface, double distance);

/// What keeps it from being built as glass: no stop, or two; surfaces that are not numbers, cross each other
/// or come in the wrong order; apertures that their surface is too curved for; indices of no glass; more than
/// 256 surfaces. Empty
/// where it is sound.
std::vector<Fault> faults_of(const Prescription& lens);

}  // namespace tessera::optics
