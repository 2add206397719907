// Names of a scene's elements, for people.
#pragma once

#include <string>

namespace tessera::wire {

/// "shape 12 (lamp)"
inline std::string place_in_scene(const char* what, int index, const std::string& name) {
  std::string place = std::string(what) + " " + std::to_string(index);
  if (!name.empty()) place += " (" + name + ")";
  return place;
}

}  // namespace tessera::wire
