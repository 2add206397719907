// Cameras and lights of glTF scenes.
#pragma once

#include <optional>
#include <vector>

#include "import/gltf/context.h"
#include "import/gltf/file/buffers.h"
#include "import/gltf/nodes.h"
#include "import/gltf/shapes/shapes.h"

namespace tessera::client::gltf {

/// Writes the camera of the options, or the first of the scene; where there is none, one that sees all of
/// `extent`. The film has its shape.
void write_camera(Context& context, const std::vector<Node>& nodes, const Extent& extent);

/// Writes KHR_lights_punctual: candela become W/sr and lux W/m2, one for one, as luminances of emissive
/// materials become radiances, and the scene's units say so. Lamps of Blender's exporter are divided by the
/// 683 lm/W that it put in. EXT_lights_ies become goniometric lights. Without any light in the scene there is
/// the sky of the options, or a warning.
void write_lights(Context& context, BufferTable& buffers, const std::vector<Node>& nodes);

/// The axes of a node at length 1, and where it is. Nothing where an axis has no length.
std::optional<Imath::M44d> without_scale(Imath::M44d t);

/// Writes the light of a node with a photometric file (EXT_lights_ies): it shines along -z, with plane C0
/// along +x. What is wrong with the file is reported.
void write_light_profile(Context& context, BufferTable& buffers, const Node& node);

}  // namespace tessera::client::gltf
