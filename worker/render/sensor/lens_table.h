// What kernels read of a lens beyond its radius: the aperture of a thin one, or all of a lens system. Lengths
// are in millimetres; the film lies in the plane z = 0, its middle on the axis, and the scene beyond the lens
// at larger z.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "render/sampling/alias_table.h"
#include "render/sampling/piecewise2d.h"

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
  // The aperture is also within these edges, at `apothem` from the axis; 0: it is a circle.
  std::int32_t first_edge = 0, edges = 0;
  float apothem = 0;
  std::int32_t refracts = 0;  // 0: the same medium is on both sides
  std::int32_t is_stop = 0;
  float coating_index = 0, coating_nm = 0;  // a layer on it; index 0: bare
};

/// Part of the plane of the pupil that light from a cell of the film can pass through. Along x of the cell it
/// spans nodes whose ends along y are given; between nodes they are straight lines.
inline constexpr std::int32_t kPupilNodes = 33;  // strips are a power of two
struct PupilNode {
  float x = 0, low = 0, high = 0;
  float area_before = 0;  // of the trapezoids up to here
};

/// The aperture of a thin lens, in units of its radius: a regular polygon, then squeezed along x.
struct ApertureRecord {
  float corners = 0;       // 0: a circle
  float first_corner = 0;  // direction, radians from x towards y
  float apothem = 1, half_edge = 0;
  float width = 1;  // what x is multiplied by
};

/// `corners`: 3 or more, or 0 for a circle; `degrees`: direction of the first of them, from x towards y;
/// `ratio` > 0: height over width.
inline ApertureRecord aperture_of(std::uint32_t corners, double degrees, double ratio) {
  ApertureRecord aperture;
  aperture.width = static_cast<float>(1 / ratio);
  if (corners == 0) return aperture;
  const double half_angle = std::numbers::pi / corners;
  aperture.corners = static_cast<float>(corners);
  // All corners are alike, so that the least turn to one of them does.
  aperture.first_corner =
      static_cast<float>(std::remainder(degrees * (std::numbers::pi / 180), 2 * half_angle));
  aperture.apothem = static_cast<float>(std::cos(half_angle));
  aperture.half_edge = static_cast<float>(std::sin(half_angle));
  return aperture;
}

/// How a thin lens is turned against the film. Rays of the place (x, y) through the point L of the lens meet
/// all points X of the ray (x, y, 1) that are on the plane of focus, where dot(plane, X) = 1.
struct LensTilt {
  float across_x[3] = {1, 0, 0}, across_y[3] = {0, 1, 0};  // the lens's plane: two unit axes, sensor space
  float plane[3] = {0, 0, 1};                              // of focus: its normal over its distance
};

/// Transmission of an aperture of any shape: the square around its circle, rows from y = -1 on, with
/// densities in proportion.
struct AperturePicture {
  Piecewise2d density;     // width 0: there is no picture
  float transmission = 0;  // what densities are multiplied by

  bool any() const { return density.width > 0; }
};

/// Two surfaces of a lens that reflect light, by their numbers.
struct BounceRecord {
  std::int32_t near_film = 0, near_scene = 0;
};

/// Light that surfaces of a lens reflect.
struct GhostTable {
  float part = 0;        // of the rays from the film, which look for ghosts; 0: nothing is reflected
  AliasTable selection;  // of a bounce, roughly by the light that it brings
  std::vector<BounceRecord> bounces;
  // Before each surface as ratios of LensTable, and behind the last.
  std::vector<float> indices;
  float per_etendue = 0;     // what radiance brings to a place of the film, for each mm^2 sr over mm^2
  float rays_of_lights = 0;  // that are sent into the lens while each pixel takes one sample; 0: none are
};

struct LensTable {
  // Thin lenses have no more than these.
  ApertureRecord aperture;
  LensTilt tilt;                               // kTiltedLens
  float barrel_length = 0, barrel_radius = 1;  // SensorRecord::has_barrel; in radii of the lens

  AperturePicture picture;  // of a thin lens, or of the stop
  GhostTable ghosts;
  std::vector<LensSurfaceRecord> surfaces;  // from the film to the scene
  std::vector<float> coefficients;
  std::vector<float> edges;  // unit vectors to the middles of edges of the stop, x and y
  // Index before a surface over that behind it, in the direction from the film: all wavelengths of the first
  // surface, then those of the second, and so on. Wavelengths are evenly spaced; one where none disperses.
  std::vector<float> ratios;
  std::int32_t wavelengths = 1;
  float first_nm = 0, wavelengths_per_nm = 0;
  float film_distance = 1;  // a place of the raster, which lies on the plane z = 1, times this is on the film
  float units_per_mm = 1e-3f;
  // The pupil, as in optics::PupilTable: one cell for each ring of the film, whose x axis points away from
  // the middle; or, where the lens is no body of revolution, rectangles.
  float pupil_z = 0;
  bool rings = true;
  std::int32_t cells_x = 1, cells_y = 1;
  float cells_per_mm_x = 0, cells_per_mm_y = 0, first_x = 0, first_y = 0;
  std::vector<PupilNode> pupil;  // kPupilNodes for each cell
  float weight = 1;              // of rays: area of the pupil (mm^2) times this, times cos^4
};

}  // namespace tessera::render
