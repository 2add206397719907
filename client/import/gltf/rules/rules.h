// The rules of glTF 2.0 for a file beyond the form of its objects: that they fit together, and that accessors
// hold what they are used for. A file that breaks such a rule is refused, whether or not its scene shows it.
#pragma once

#include "import/gltf/context.h"
#include "import/gltf/file/accessors.h"
#include "import/gltf/file/buffers.h"
#include "import/gltf/rules/accessor_uses.h"

namespace tessera::client::gltf {

/// Reports all that is broken, by the rules of the specification's sections 3.6 to 3.11.
void check_rules(Context& context, BufferTable& buffers, AccessorTable& accessors);

// Its parts, in files of their own; `uses` learns what accessors are for.
void check_objects(Context& context, BufferTable& buffers, AccessorUses& uses);
void check_meshes(Context& context, AccessorTable& accessors, AccessorUses& uses);
void check_skins(Context& context, AccessorTable& accessors, AccessorUses& uses);
void check_animations(Context& context, AccessorTable& accessors, AccessorUses& uses);
void check_values(Context& context, AccessorTable& accessors, const AccessorUses& uses);

}  // namespace tessera::client::gltf
