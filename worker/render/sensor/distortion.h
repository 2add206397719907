// Places of a distorted film, and those that a sensor without distortion has for the same rays.
#pragma once

#include "render/core/vec.h"
#include "render/sensor/distortion_table.h"

namespace tessera::render::TESSERA_ISA {

struct MovedPlace {
  Vec2 place;
  Float area;  // of undistorted places for one of the film's
  Mask valid;  // else it is beyond the table
};

/// The undistorted place that a place of the film sees.
MovedPlace undistort(const DistortionTable& table, Vec2 film);
/// The place of the film that sees an undistorted place, by Newton's method.
MovedPlace distort(const DistortionTable& table, Vec2 undistorted);

/// Derivatives of undistorted places by the film's; xy: of x by y.
struct PlaceSlopes {
  Float xx, xy, yx, yy;
};
/// Those where an undistorted place is seen, roughly: linear between a few thousand places, and beyond the
/// outermost the same.
PlaceSlopes slopes_near(const DistortionTable& table, Vec2 undistorted);

}  // namespace tessera::render::TESSERA_ISA
