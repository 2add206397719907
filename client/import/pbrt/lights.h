// LightSource and AreaLightSource -> lights of the scene.
#pragma once

#include <optional>

#include "import/pbrt/context.h"
#include "import/pbrt/parameters.h"

namespace tessera::client::pbrt {

/// Adds a light of `type` ("distant", "infinite", "point", "spot", ...) to the scene.
void add_light(Context& context, const std::string& type, ParameterList& parameters, const Transform& world_from_light);

/// A diffuse emitter, before it is bound to a shape.
struct AreaLightInput {
  v1::AreaLight light;
  double power = 0;  // of the whole shape, in place of a radiance; 0: none
  SourceLocation where;
};

/// Nothing after an error.
std::optional<AreaLightInput> read_area_light(Context& context, const std::string& type, ParameterList& parameters);

}  // namespace tessera::client::pbrt
