#pragma once

namespace tessera::render {

/// Returns the square, in the double precision that tables are made in.
inline double sqr(double x) { return x * x; }

}  // namespace tessera::render
