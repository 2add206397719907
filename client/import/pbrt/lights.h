// LightSource and AreaLightSource -> lights of the scene.
#pragma once

#include <optional>

#include "import/pbrt/matter/textures.h"

namespace tessera::client::pbrt {

/// Adds a light of `type` ("distant", "infinite", "point", "spot", "projection", "goniometric") to the scene.
/// `world_from_light` is for the two ends of the exposure.
void add_light(Context& context, SceneTextures& textures, const std::string& type, ParameterList& parameters,
               const MovingTransform& world_from_light);

/// A diffuse emitter, before it is bound to a shape.
struct AreaLightInput {
  v1::AreaLight light;
  double power = 0;       // power of each shape, in place of a radiance; 0: none
  double mean_image = 1;  // mean luminance of its image
  SourceLocation where;
};

/// Nothing after an error.
std::optional<AreaLightInput> read_area_light(Context& context, SceneTextures& textures,
                                              const std::string& type, ParameterList& parameters);

}  // namespace tessera::client::pbrt
