// The kinds of materials, one function each. What the slots mean is in bsdf/kinds.h.
#pragma once

#include "absl/status/status.h"
#include "render/scene/material/material_slots.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::render {

/// Fills the record of a material of any kind but a mix, which is made of other materials.
absl::Status set_kind(const v1::Material& material, MaterialSlots& slots);

/// That of glTF's layers.
absl::Status set_gltf(const v1::Material& material, MaterialSlots& slots);

}  // namespace tessera::render
