// Pictures of any pixels, denoised: width, height, method, samples, then the floats of all channels.
#include "denoise/denoise.h"

#include <cmath>
#include <cstring>

#include "fuzz/target.h"

namespace tessera::fuzz {
namespace {

constexpr std::size_t kHeader = 4;

/// The i-th float of the bytes, which are repeated.
float float_at(std::string_view bytes, std::size_t i) {
  char taken[sizeof(float)];
  for (std::size_t b = 0; b < sizeof taken; ++b) taken[b] = bytes[(i * sizeof taken + b) % bytes.size()];
  float value = 0;
  std::memcpy(&value, taken, sizeof value);
  return value;
}

bool accepts_denoise(std::string_view bytes) {
  if (bytes.size() <= kHeader) return false;
  const auto header = [&](std::size_t i) { return static_cast<int>(static_cast<unsigned char>(bytes[i])); };
  client::Image image;
  image.data = image.display = {0, 0, 1 + header(0) % 24, 1 + header(1) % 24};
  image.metadata["tessera.spp"] = static_cast<std::int32_t>(header(3));
  std::size_t next = 0;
  for (const char* const layer : {"", "variance.", "albedo.", "half.", "half.albedo."}) {
    for (const char* const band : {"R", "G", "B"}) image.add(std::string(layer) + band);
  }
  for (const char* const band : {"X", "Y", "Z"}) {
    image.add(std::string("normal.") + band);
    image.add(std::string("half.normal.") + band);
  }
  image.add("depth.Z"), image.add("half.depth.Z");
  for (client::Channel& channel : image.channels) {
    for (float& value : channel.values) value = float_at(bytes.substr(kHeader), next++);
  }
  const client::DenoiseMethod method =
      header(2) % 2 == 0 ? client::DenoiseMethod::kStatistical : client::DenoiseMethod::kRegression;
  if (!client::denoise_image({.method = method, .threads = 1, .oidn_library = ""}, image).ok()) return false;
  for (const char* const band : {"R", "G", "B"}) {
    for (const float value : image.find(band)->values)
      require(std::isfinite(value), "a denoised pixel that is not finite");
  }
  return true;
}

}  // namespace

const Target kDenoise = {"denoise", accepts_denoise};

}  // namespace tessera::fuzz
