// Writes the pictures of a capture into the files of a light field.
#pragma once

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "image/exr.h"
#include "image/image.h"
#include "light_field/manifest.h"

namespace tessera::client {

class SetWriter {
 public:
  /// `manifest` says how files are laid out, and gets a view for each picture. It outlives the writer.
  SetWriter(std::string folder, light_field::Manifest& manifest);

  /// Makes the folders. FailedPrecondition where there is a light field already.
  absl::Status begin() const;
  /// Writes the picture of view `number` (R, G, B, A, depth.Z), and says in the manifest where its tiles are;
  /// the camera there stays. Internal where the disk does not take it.
  absl::Status write(std::uint32_t number, const Image& picture);
  /// Writes the manifest, after all views: where it is there, they are.
  absl::Status finish();

 private:
  ExrFormat format() const;
  absl::Status measure_loss(const std::string& path, const Image& written);

  const std::string folder_;
  light_field::Manifest& manifest_;
  double squared_error_ = 0;  // of 8-bit sRGB codes
  std::uint64_t codes_ = 0;
};

}  // namespace tessera::client
