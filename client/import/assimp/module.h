// Interface of the module with Assimp: one function, without exceptions.
#pragma once

#include <string>
#include <vector>

namespace tessera::client::assimp {

struct AssimpModule {
  /// Reads a file of any kind that Assimp knows by its name, and writes it as a .glb whose images are named
  /// relative to the file. False with what is wrong, without the file's name.
  bool (*to_glb)(const std::string& file, std::string& glb, std::vector<std::string>& warnings,
                 std::string& fault);
};

/// The one symbol that the module exports.
inline constexpr const char* kAssimpModuleFile = "libtessera_assimp.so";
inline constexpr const char* kAssimpModuleEntry = "tessera_assimp";
using AssimpModuleEntry = const AssimpModule* (*)();

}  // namespace tessera::client::assimp
