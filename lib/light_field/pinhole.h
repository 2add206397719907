// Calibrated cameras of a light field: pinholes with a window of their own.
#pragma once

#include <ImathVec.h>

#include <array>
#include <optional>
#include <span>

namespace tessera::light_field {

/// Row by row; acts on columns.
using Matrix4 = std::array<double, 16>;

/// A point at (X, Y, Z) of camera space (x right, y up, z into the scene) is seen at the place
/// (cx + fx X / Z, cy - fy Y / Z) of the picture: pixels from its upper left corner, so that the middle of
/// the first pixel is (0.5, 0.5). World space has any handedness, and the matrix may scale.
struct Pinhole {
  Matrix4 world_from_camera{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  double fx = 1, fy = 1, cx = 0, cy = 0;

  bool operator==(const Pinhole&) const = default;
  Imath::V3d place() const { return {world_from_camera[3], world_from_camera[7], world_from_camera[11]}; }
  /// World-space direction, of any length, of the light that is seen at a place of the picture; its z in
  /// camera space is 1.
  Imath::V3d direction(double x, double y) const;
};

/// The part of the plane z = 1 that a picture shows, of a camera that looks along z.
struct ImageWindow {
  double x0 = -1, x1 = 1, y0 = -1, y1 = 1;  // y up
};
/// Sets fx, fy, cx and cy so that a picture of these pixels shows the window.
void set_window(const ImageWindow& window, double width, double height, Pinhole& camera);
ImageWindow window_of(const Pinhole& camera, double width, double height);

Imath::V3d transformed_point(const Matrix4& m, const Imath::V3d& p);
Imath::V3d transformed_vector(const Matrix4& m, const Imath::V3d& v);
/// Nothing where the upper three rows are singular, or no numbers.
std::optional<Matrix4> inverse(const Matrix4& m);
/// A camera at `place` that looks along `toward`, its y axis towards `up`; or along any axis where the two
/// are parallel. `mirrored`: its axes have the other handedness, as in worlds where z comes out of pictures.
Matrix4 looking(const Imath::V3d& place, const Imath::V3d& toward, const Imath::V3d& up, bool mirrored);
/// Whether the matrix changes the handedness of what it transforms.
bool mirrors(const Matrix4& m);

/// Where points of world space, less an origin, are seen, in single precision.
struct Projection {
  float rows[3][4] = {};  // to (x w, y w, w), with the camera-space z as w

  /// `camera` has an inverse.
  static Projection of(const Pinhole& camera, const Imath::V3d& origin);
  Imath::V3f homogeneous(const Imath::V3f& p) const {
    const auto row = [&](const float(&r)[4]) { return r[0] * p.x + r[1] * p.y + r[2] * p.z + r[3]; };
    return {row(rows[0]), row(rows[1]), row(rows[2])};
  }
};

}  // namespace tessera::light_field
