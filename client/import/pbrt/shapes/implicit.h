// Shape "implicit", which is not pbrt's -> an ImplicitSurface message.
#pragma once

#include "import/pbrt/shapes/shapes.h"

namespace tessera::client::pbrt {

/// "string expression", bounds ("point3 pmin" and "point3 pmax", or "float radius" and "point3 center"),
/// "string roots", "float lipschitz".
ShapeResult write_implicit(ValueReader& values, v1::Shape& shape);

}  // namespace tessera::client::pbrt
