// A fuzz target: a function that takes any bytes, and must return.
#pragma once

#include <random>
#include <string>
#include <string_view>
#include <vector>

namespace tessera::fuzz {

struct Target {
  const char* name;  // also of its folder in tests/fuzz/corpus
  /// Whether the bytes were accepted. Ends the process when a promise of the code under test does not hold.
  bool (*accepts)(std::string_view bytes);
  /// A variant of an input; null: mutate_bytes() will do.
  std::string (*mutate)(std::string bytes, std::mt19937& random) = nullptr;
};

// ---- client/image
extern const Target kExr;
// ---- client/import
extern const Target kPly, kObj, kSerialized, kVolumeFile, kPbrt, kMitsuba, kGltf, kTextScene, kLens;
// ---- proto/wire, lib/images, lib/layers, lib/expression, lib/photometry
extern const Target kTileResult, kMeshBlob, kVolumeBlob, kImage, kLayers, kExpression, kPhaseBlob,
    kPackedInstances, kWeather, kLamp;
// ---- server
extern const Target kJournal, kUpload, kWebRequest;
// ---- client/command, client/denoise
extern const Target kConfig, kDenoise;
// ---- worker
extern const Target kSceneBuild, kCsg, kNoisePilot;

/// A broken promise: says so and aborts, for there is no test framework around a target.
void require(bool promise, const char* what);

/// A copy with nothing behind its last byte, so that an address sanitizer sees every step too far.
std::vector<char> exact(std::string_view bytes);

/// Writes `bytes` to a file of that name in a folder of this process's own, and returns its path.
std::string scratch_file(const std::string& name, std::string_view bytes);

/// One to four edits: bytes changed, pieces removed, doubled, moved, or replaced by something nasty.
std::string mutate_bytes(std::string bytes, std::mt19937& random);

/// Inputs of several parts, each behind its length (32 bits, little endian). The last may be cut off.
std::vector<std::string> split_parts(std::string_view bytes);
std::string join_parts(const std::vector<std::string>& parts);

}  // namespace tessera::fuzz
