// Which shapes are shaded together: see SceneTables::shading_groups.
#pragma once

#include "render/bsdf/material_table.h"
#include "render/integrator/scene_tables.h"
#include "render/shape/shape_table.h"

namespace tessera::render {

/// Sets the groups of `tables`; none where there is nothing to gain.
void group_for_shading(const ShapeTable& shapes, const MaterialTable& materials, SceneTables& tables);

}  // namespace tessera::render
