// Names that stand once each, of things that may be called alike.
#pragma once

#include <map>
#include <set>
#include <string>

#include "import/input/concat.h"

namespace tessera::client::gltf {

class UniqueNames {
 public:
  /// `wanted`, or "wanted-2", "wanted-3" and so on where it is taken.
  std::string unique(const std::string& wanted) {
    std::string name = wanted;
    for (int& last = last_.try_emplace(wanted, 1).first->second; !taken_.insert(name).second;)
      name = concat(wanted, "-", ++last);
    return name;
  }

 private:
  std::set<std::string> taken_;
  std::map<std::string, int> last_;  // number that a name was given
};

}  // namespace tessera::client::gltf
