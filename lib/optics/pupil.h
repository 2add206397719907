// What part of a plane behind a lens the light of each place on the film comes through.
#pragma once

#include <cstddef>
#include <vector>

#include "optics/lens_system.h"

namespace tessera::optics {

struct Point {
  double x = 0, y = 0;
};

/// The plane in which pupils are told: the paraxial exit pupil where that lies well before the film, else the
/// last vertex.
double pupil_plane(const LensSystem& lens);

/// The outline of the part of pupil_plane() through which light of this wavelength reaches a point of the
/// film, as a polygon with its corners on the edge; empty where there is no light. `near`: a point that
/// probably is within it.
std::vector<Point> pupil_outline(const LensSystem& lens, Point film, double nm, Point near);

/// Irradiance in the middle of the film where the scene's radiance is 1.
double axial_irradiance(const LensSystem& lens);

/// Between nodes, which lie along x, a cell's edges along y are straight lines.
struct PupilNode {
  double x = 0, low = 0, high = 0;
  double area_before = 0;  // of the trapezoids up to here
};

/// Parts of the plane that hold the whole pupil of all places of a cell of the film. Of round lenses, a cell
/// is a ring: x points from the middle of the film to the place. Of others it is a rectangle of the film, and
/// x and y are those of the film.
struct PupilTable {
  double z = 0;  // of the plane
  bool rings = true;
  int cells_x = 0, cells_y = 1;
  double cell_x = 1, cell_y = 1;    // size of a cell, mm
  double first_x = 0, first_y = 0;  // where the first one begins
  int nodes_per_cell = 0;
  std::vector<PupilNode> nodes;

  static constexpr int kNodes = 33;
};

/// For film within these distances from its middle, along x and y, and light of these wavelengths.
PupilTable pupil_table(const LensSystem& lens, double half_width, double half_height,
                       const std::vector<double>& wavelengths = {kLineD});

}  // namespace tessera::optics
