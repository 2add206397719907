// The image files that textures are made of.
#pragma once

#include <map>
#include <memory>
#include <set>
#include <string>

#include "absl/status/status.h"
#include "render/build/blob_source.h"
#include "render/color/texture_table.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::render {

class TextureImages {
 public:
  /// Where the image will be: every file once for each way of decoding it. Keeps a reference to the message.
  std::shared_ptr<const TextureImage> slot(const v1::ImageTexture& image);
  /// The image of a slot will be decoded.
  void need(const TextureImage* slot) { needed_.insert(slot); }
  /// Fills the images that are needed, on up to `threads` threads. Errors name the image's file.
  absl::Status decode(const BlobSource& blobs, int threads);

 private:
  struct Slot {
    const v1::ImageTexture* source = nullptr;
    std::shared_ptr<TextureImage> image;
  };
  std::map<std::string, Slot> slots_;  // by digest and encoding
  std::set<const TextureImage*> needed_;
};

}  // namespace tessera::render
