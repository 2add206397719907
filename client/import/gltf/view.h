// Cameras and lights of glTF scenes.
#pragma once

#include <vector>

#include "import/gltf/context.h"
#include "import/gltf/nodes.h"
#include "import/gltf/shapes/shapes.h"

namespace tessera::client::gltf {

/// Writes the camera of the options, or the first of the scene; where there is none, one that sees all of
/// `extent`. The film has its shape.
void write_camera(Context& context, const std::vector<Node>& nodes, const Extent& extent);

/// Writes KHR_lights_punctual: candela become W/sr and lux W/m2, one for one, as luminances of emissive
/// materials become radiances. Lamps of Blender's exporter are divided by the 683 lm/W that it put in.
/// Without any light in the scene there is the sky of the options, or a warning.
void write_lights(Context& context, const std::vector<Node>& nodes);

}  // namespace tessera::client::gltf
