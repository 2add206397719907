// Interface of the module with OpenColorIO, without exceptions and Abseil.
#pragma once

#include <string>

namespace tessera::client {

struct OcioModule {
  /// Returns what show() takes, or null, and then what is wrong with the configuration, a file, or with what
  /// is asked for. Empty names stand for the configuration's own choice.
  void* (*open)(const std::string& config, const std::string& display, const std::string& view,
                const std::string& space, std::string& message);
  /// Replaces the colours of that many pixels, three values each, by what the screen is sent.
  void (*show)(const void* processor, float* rgb, long pixels);
  void (*close)(void* processor);
};

/// The one symbol that the module exports.
inline constexpr const char* kOcioModuleFile = "libtessera_ocio.so";
inline constexpr const char* kOcioModuleEntry = "tessera_ocio";
using OcioModuleEntry = const OcioModule* (*)();

}  // namespace tessera::client
