// Mitsuba emitters -> Light messages and area lights.
#pragma once

#include "import/mitsuba/textures.h"

namespace tessera::client::mitsuba {

/// An emitter that stands in the scene by itself.
void write_light(Context& context, TextureTable& textures, Object& emitter);

/// An emitter "area" inside a shape.
void write_area_light(Context& context, TextureTable& textures, Object& emitter, v1::Shape& shape);

}  // namespace tessera::client::mitsuba
