// Which tests rays and triangles are met by.
#pragma once

#include <string>
#include <vector>

#include "render/build/view/settings.h"
#include "render/shape/shape_table.h"

namespace tessera::render {

/// Whether triangles are to be met by robust tests: as the job says, or as a probe of the shapes does, which
/// warns of what it found. `names`: the shapes' places in the scene.
bool wants_robust_intersection(const ShapeTable& shapes, const std::vector<std::string>& names,
                               v1::Intersection wanted, std::vector<std::string>& warnings);

}  // namespace tessera::render
