// Mitsuba emitters -> Light messages and area lights.
#pragma once

#include "import/mitsuba/matter/textures.h"

namespace tessera::client::mitsuba {

/// An emitter that stands in the scene by itself.
void write_light(Context& context, SceneTextures& textures, Object& emitter);

/// An emitter "area" inside a shape. `may_have_normals`: the shape is a mesh whose vertices may have normals
/// of their own.
void write_area_light(Context& context, SceneTextures& textures, Object& emitter, bool may_have_normals,
                      v1::Shape& shape);

/// To be called once all emitters are written: how often Mitsuba picks one depends on the others.
void finish_area_lights(Context& context);

}  // namespace tessera::client::mitsuba
