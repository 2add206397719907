// Promises of the readers of meshes.
#pragma once

#include "fuzz/target.h"
#include "wire/mesh_blob.h"

namespace tessera::fuzz {

/// A sound mesh, or an error with a message. True for the former.
template <typename Result>
bool is_sound_mesh(const Result& result) {
  if (result.ok()) {
    require(wire::decode_mesh(wire::encode_mesh(result->mesh)).ok(), "a reader made an unsound mesh");
  } else {
    require(!result.status().message().empty(), "an error without a message");
  }
  return result.ok();
}

}  // namespace tessera::fuzz
