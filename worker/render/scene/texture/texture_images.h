// The image files that textures are made of.
#pragma once

#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "render/color/texture_table.h"
#include "render/scene/blob_source.h"
#include "render/scene/texture/shared_images.h"
#include "tessera/v1/scene.pb.h"

namespace tessera::render {

class TextureImages {
 public:
  /// `shared` may be null: nothing is decoded yet.
  explicit TextureImages(SharedImages* shared = nullptr) : shared_(shared) {}

  /// Where the image, or its pyramid, will be: every file once for each way of decoding it. Keeps a reference
  /// to the message.
  std::shared_ptr<const TextureImage> slot(const v1::ImageTexture& image, bool pyramid);
  /// The slot of the same file with or without a pyramid.
  std::shared_ptr<const TextureImage> twin(const TextureImage* slot, bool pyramid);
  /// The image of a slot will be decoded.
  void need(const TextureImage* slot) { needed_.insert(slot); }
  /// Fills the images that are needed, on up to `threads` threads. Errors name the image's file.
  absl::Status decode(const BlobSource& blobs, int threads);
  /// Errors of decode() that the headers of the files tell, which are all that is read.
  std::vector<std::pair<const v1::ImageTexture*, absl::Status>> refusals(const BlobSource& blobs) const;

 private:
  struct Slot {
    const v1::ImageTexture* source = nullptr;
    bool pyramid = false;
    bool decoded = false;  // decoded for another scene
    std::shared_ptr<TextureImage> image;
  };
  SharedImages* const shared_;
  std::map<std::string, Slot> slots_;  // keys: digest, encoding and whether there is a pyramid
  std::set<const TextureImage*> needed_;
};

}  // namespace tessera::render
