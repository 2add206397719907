// Places within pixels that samples of one number share.
#pragma once

#include <cstdint>

namespace tessera::render {

struct Place {
  float x, y;  // offsets from the pixel's upper left corner, in [0, 1)
};

/// Point `index` of Sobol's first two dimensions, a (0,2)-sequence: each is evenly spread by itself, too,
/// which edges along rows and columns need. Random digits of the `seed`, the same in all points, make each of
/// them evenly distributed [Kollig & Keller 2002].
Place shifted_place(std::uint64_t seed, std::uint32_t index);

/// The same with digits that depend on the digits before them [Owen 1995]: points are a (0,2)-sequence still,
/// but each lies anywhere within its cell, independently of the others, so that means over them err by n^-1.5
/// where those of shifted points, which all lie at one place of their cells, err by 1 / n.
Place scrambled_place(std::uint64_t seed, std::uint32_t index);

}  // namespace tessera::render
