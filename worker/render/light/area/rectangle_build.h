#pragma once

#include "render/light/light_table.h"

namespace tessera::render::TESSERA_ISA {

/// Makes one kRectangle of two kTriangle lights of one mesh that lie side by side, are turned the same way
/// and have no texture, where they are a rectangle to a part in 50,000 of its sides: `second` becomes the
/// same as `first`, whose index is `first_index`. False when they are none.
bool merge_into_rectangle(LightRecord& first, std::int32_t first_index, LightRecord& second);

}  // namespace tessera::render::TESSERA_ISA
