// Mitsuba films -> Film message.
#pragma once

#include "import/mitsuba/context.h"

namespace tessera::client::mitsuba {

/// The whole film, and the part of it that is rendered; pixels.
struct FilmWindow {
  double width = 768, height = 576;
  double crop_x = 0, crop_y = 0, crop_width = 768, crop_height = 576;
};

/// Writes the size of the crop window and the filter. `film` may be null: Mitsuba's defaults.
FilmWindow write_film(Context& context, Object* film);

}  // namespace tessera::client::mitsuba
