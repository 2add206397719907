// Context that every part of the Mitsuba importer writes to.
#pragma once

#include <set>
#include <string>
#include <unordered_map>

#include "import/input/blob_collector.h"
#include "import/input/diagnostics.h"
#include "import/mitsuba/document/values.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::client::mitsuba {

struct Context {
  Diagnostics diagnostics;
  BlobCollector blobs;
  v1::Scene scene;
  Document document;
  int threads = 0;                             // 0: one a core
  double shutter_open = 0, shutter_close = 0;  // seconds; things move in between
  double emitter_weight = 0;                   // "sampling_weight" of all emitters so far
  std::unordered_map<const void*, Diagnostic>
      places;  // ImportedScene::places, but for shapes: they may be many

  /// The object's id, else `kind` and a number; not in `taken`, which it joins.
  static std::string unique_name(const Object& object, const std::string& kind, std::set<std::string>& taken);
  /// For messages of whoever reads the scene later: "lamp, scene.xml:12"; the plugin's name where there is no
  /// id.
  std::string name_with_place(const Object& object) const;
  /// Notes that an element of the scene is made of the object.
  void note(const google::protobuf::Message& element, const Object& object);
};

}  // namespace tessera::client::mitsuba
