// Distortion of a lens, as the kernels read it: for each place of the film the place that a sensor without
// distortion sees there. A table over the film and some pixels around it, in the sensor's own places
// (RasterShape), holds the differences between the two, so that they keep their digits.
#pragma once

#include <cstdint>
#include <vector>

namespace tessera::render {

/// Evenly spaced nodes; a place's number of cells from the first node is (place - first) * per_place.
struct PlaceGrid {
  std::int32_t columns = 1, rows = 1;  // cells
  float first_x = 0, first_y = 0, per_x = 1, per_y = 1;
};

struct DistortionTable {
  /// Smooth tables are bicubic [Hermite]: a node has the difference in x, its derivatives along columns,
  /// along rows and along both, for steps of one cell, and the same for y. Others are bilinear: x and y.
  bool smooth = true;
  PlaceGrid grid;
  std::vector<float> nodes;  // kSmoothNode or kBilinearNode floats each, rows of them
  /// The inverse begins its search here: for each cell of the places that are seen, a place of the film, x
  /// and y.
  PlaceGrid start_grid;
  std::vector<float> starts;
  /// Derivatives of the undistorted place by the film's, for footprints: of x by x and y, of y by x and y, at
  /// each node of the start grid. Nodes that no place of the film sees go straight on from the next ones.
  std::vector<float> slopes;
  float near = 1e-3f;  // a thousandth of a pixel, in places

  static constexpr std::int32_t kSmoothNode = 8, kBilinearNode = 2;
};

}  // namespace tessera::render
