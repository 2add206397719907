#include "import/gltf/rules/rules.h"

namespace tessera::client::gltf {

void check_rules(Context& context, BufferTable& buffers, AccessorTable& accessors) {
  AccessorUses uses(context);
  check_objects(context, buffers, uses);
  check_meshes(context, accessors, uses);
  check_skins(context, accessors, uses);
  check_animations(context, accessors, uses);
  if (!context.diagnostics.has_errors() && !context.is_converted) check_values(context, accessors, uses);
}

}  // namespace tessera::client::gltf
