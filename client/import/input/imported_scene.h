// Result of an import: the Scene message and the bytes that it refers to.
#pragma once

#include <map>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "import/input/diagnostics.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::client {

/// The bytes behind one digest. Meshes are held in memory; textures stay in their files, to be read when
/// needed.
struct SceneBlob {
  v1::BlobRef ref;    // digest and size always set
  std::string bytes;  // owned, when `file` is empty
  std::string file;   // else: the file that holds exactly these bytes
};

struct ImportedScene {
  v1::Scene scene;
  std::vector<SceneBlob> blobs;  // one a digest, in order of first use
  std::vector<Diagnostic> warnings;
  // Where the file has elements that may be faulty, by their messages in `scene`, and what they are:
  // "shape (lamp): ".
  std::unordered_map<const void*, Diagnostic> places = {};
  // The same of single fields of lenses, by their numbers.
  std::map<std::pair<const void*, int>, Diagnostic> field_places = {};
  std::string file = "";  // file that it was read from
};

}  // namespace tessera::client
