// Context that every part of the pbrt importer writes to.
#pragma once

#include <filesystem>
#include <string>
#include <unordered_map>
#include <utility>

#include "import/input/blob_collector.h"
#include "import/input/diagnostics.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::client::pbrt {

struct Context {
  Diagnostics diagnostics;
  BlobCollector blobs;
  v1::Scene scene;
  /// Directory of the main file: all names in all files are relative to it, as in pbrt.
  std::filesystem::path directory;
  int threads = 0;                                     // 0: one a core
  std::unordered_map<const void*, Diagnostic> places;  // ImportedScene::places

  /// Notes where an element stands, and what it is: "point light: ".
  void note(const google::protobuf::Message& element, SourceLocation where, std::string what) {
    if (where.line > 0)
      places[&element] = {diagnostics.file_name(where.file), where.line, where.column, std::move(what)};
  }
  std::filesystem::path resolve(const std::string& file) const { return directory / file; }
};

}  // namespace tessera::client::pbrt
