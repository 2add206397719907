// A lens system as the kernels read it. Lengths are in millimetres; the film lies in the plane z = 0, its
// middle on the axis, and the scene beyond the lens at larger z.
#pragma once

#include <cstdint>
#include <vector>

namespace tessera::render {

enum class LensSurfaceShape : std::int32_t {
  kPlane,  // the stop, too
  kSphere,
  kConic,     // of revolution
  kAsphere,   // a conic and even powers of the height
  kCylinder,  // a circle, conic or asphere across one direction
};

/// A surface that rays from the film meet. Its sag, towards +z, is that of the curvature and the conic
/// constant plus the polynomial: that sum as seen from the film has the opposite sign of the prescription's.
struct LensSurfaceRecord {
  LensSurfaceShape shape = LensSurfaceShape::kPlane;
  float z = 0;          // of the vertex
  float curvature = 0;  // 1/mm
  float conic = 0;
  float aperture_squared = 0;                            // of the clear radius
  float straight_x = 0, straight_y = 1;                  // unit direction along which a cylinder is straight
  std::int32_t first_coefficient = 0, coefficients = 0;  // of height^4, height^6, ...
  std::int32_t blades = 0;    // the aperture is a polygon within its circle; 0: it is that circle
  float blade_angle = 0;      // of the first corner, radians
  std::int32_t refracts = 0;  // 0: the same medium is on both sides
};

/// Part of the plane of the pupil that light from a cell of the film can pass through. Along x of the cell it
/// spans nodes whose ends along y are given; between nodes they are straight lines.
struct PupilNode {
  float x = 0, low = 0, high = 0;
  float area_before = 0;  // of the trapezoids up to here
};

struct LensTable {
  std::vector<LensSurfaceRecord> surfaces;  // from the film to the scene
  std::vector<float> coefficients;
  // Index before a surface over that behind it, in the direction from the film: all wavelengths of the first
  // surface, then those of the second, and so on. Wavelengths are evenly spaced; one where none disperses.
  std::vector<float> ratios;
  std::int32_t wavelengths = 1;
  float first_nm = 0, wavelengths_per_nm = 0;
  float film_distance = 1;  // a place of the raster, which lies on the plane z = 1, times this is on the film
  float units_per_mm = 1e-3f;
  // The pupil: one cell for each ring of the film, whose x axis points away from the middle; or, where the
  // lens is no body of revolution, cells of a grid.
  float pupil_z = 0;
  std::int32_t cells_x = 1, cells_y = 0;  // cells_y 0: rings
  float cells_per_mm_x = 0, cells_per_mm_y = 0, first_x = 0, first_y = 0;
  std::int32_t nodes_per_cell = 0;
  std::vector<PupilNode> pupil;
  float weight = 1;  // of rays: area of the pupil (mm^2) times this, times cos^4
};

}  // namespace tessera::render
