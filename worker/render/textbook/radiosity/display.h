// From patches to what is seen: vertices between which light is interpolated.
#pragma once

#include "render/shape/shape_table.h"
#include "render/textbook/radiosity/solve.h"
#include "wire/phases/radiosity_solution.h"

namespace tessera::render::TESSERA_ISA::radiosity {

using wire::Solution;

/// Nodes, patches and vertices of a solved forest. A vertex has the mean light of the patches that it is a
/// corner of; where it stands in the middle of an edge of a larger patch (a T-vertex), it has what that patch
/// has there, so that no gap is seen [Cohen & Wallace 1993, chapter 9]. Patches of one side, or of
/// neighbouring sides of one material that meet under less than 30 degrees, share vertices.
Solution show(const ShapeTable& shapes, const Surfaces& surfaces, const Forest& forest);

/// Data that a point of a side gets of its patch.
struct Shown {
  Colour irradiance;
  int patch_level = 0;
};
/// `at`: weights of the triangle's corners.
Shown look_up(const Solution& solution, Side side, Weights at);

}  // namespace tessera::render::TESSERA_ISA::radiosity
