// The kinds of materials, one function each. What the slots mean is in bsdf/slots.h.
#pragma once

#include "absl/status/status.h"
#include "render/scene/material/material_slots.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::render {

/// Fills the record of a material of any kind but a mix, which is made of other materials.
absl::Status set_kind(const v1::Material& material, MaterialSlots& slots);

/// That of glTF's layers.
absl::Status set_gltf(const v1::Material& material, MaterialSlots& slots);

/// Whether a record that is filled has a delta lobe: a mirror, clear glass, or a clear coat over something
/// else.
bool has_delta_lobe(const MaterialRecord& material);

}  // namespace tessera::render
