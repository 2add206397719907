// The data that every part of the glTF importer reads and writes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>

#include "import/gltf/file/json_text.h"
#include "import/gltf/gltf_options.h"
#include "import/input/blob_collector.h"
#include "import/input/concat.h"
#include "import/input/diagnostics.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::client::gltf {

struct Context {
  Diagnostics diagnostics;
  std::string file_name;
  std::filesystem::path folder;  // folder that relative names of files begin at
  BlobCollector blobs;
  v1::Scene scene;
  Json document;
  std::string_view glb_binary_chunk;
  GltfOptions options;
  bool is_converted = false;        // made by a converter: of sound numbers, but not all that glTF demands
  std::uint64_t elements_left = 0;  // elements that may still be read: many accessors may share few bytes
  std::uint64_t pixels_left = std::uint64_t{1} << 28;  // pixels of images that may still be changed

  /// Messages have the file and the place in it: "scene.gltf: /meshes/0/primitives/1: ...".
  void error(std::string_view place, const std::string& message) {
    if (!diagnostics.full()) diagnostics.error(located(place), message);
  }
  void warn(std::string_view place, const std::string& message) {
    diagnostics.warning(located(place), message);
  }

  /// Counts elements that are read for `place`; false where there are more than the file's size explains,
  /// which has been reported.
  bool spend(std::uint64_t elements, std::string_view place) {
    if (elements <= elements_left) {
      elements_left -= elements;
      return true;
    }
    error(place, "the file asks for more than its size explains: its data are read too often");
    elements_left = 0;
    return false;
  }

 private:
  SourceLocation located(std::string_view place) {
    return {.file = diagnostics.add_file(place.empty() ? file_name
                                                       : concat(file_name, ": ", std::string(place)))};
  }
};

}  // namespace tessera::client::gltf
