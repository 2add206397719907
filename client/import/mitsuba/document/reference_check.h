// <ref>: from ids to objects.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "import/input/diagnostics.h"
#include "import/mitsuba/document/values.h"

namespace tessera::client::mitsuba {

/// A property that stands for another object until all objects are known.
struct Reference {
  Object* owner = nullptr;
  std::string name;
  std::string id;
  SourceLocation where;
};

/// Puts the objects in the references' places. Errors, and properties left out: an unknown id, objects that
/// contain themselves, objects nested so deep that nothing real needs it.
void resolve_references(const std::vector<Reference>& references, const std::map<std::string, Object*>& ids,
                        Document& document, Diagnostics& diagnostics);

}  // namespace tessera::client::mitsuba
