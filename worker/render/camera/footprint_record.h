// The part of a camera that footprints need, as the kernels read it.
#pragma once

namespace tessera::render {

/// The camera half-way through the exposure.
struct FootprintRecord {
  bool on = false;  // else textures are not filtered
  // Unit axes of the camera (right, up, forward) and its place, render space.
  float x[3] = {1, 0, 0}, y[3] = {0, 1, 0}, z[3] = {0, 0, 1}, place[3] = {0, 0, 0};
  bool parallel = false;  // rays: `spread` is a length, else an angle in radians
  float spread_x = 0, spread_y = 0;
  float least_cosine = 1;  // of the angle to the axis: up to there, pixels of a flat film become smaller
};

}  // namespace tessera::render
