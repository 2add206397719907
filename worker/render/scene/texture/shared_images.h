// Decoded images of the scenes that are loaded.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>

namespace tessera::render {

struct TextureImage;

/// Images by their files and how these were decoded: where something in a scene has moved, it is built anew,
/// but its pictures are the same. Holds nothing alive. Thread-safe.
class SharedImages {
 public:
  /// Null when there is none of that key.
  std::shared_ptr<TextureImage> find(const std::string& key) {
    const std::lock_guard lock{mutex_};
    const auto found = images_.find(key);
    std::shared_ptr<TextureImage> image = found == images_.end() ? nullptr : found->second.lock();
    if (image) ++shared_;
    return image;
  }
  void add(const std::string& key, const std::shared_ptr<TextureImage>& image) {
    const std::lock_guard lock{mutex_};
    std::erase_if(images_, [](const auto& entry) { return entry.second.expired(); });
    images_[key] = image;
  }
  /// How often find() found something.
  std::uint64_t shared() const {
    const std::lock_guard lock{mutex_};
    return shared_;
  }

 private:
  mutable std::mutex mutex_;
  std::map<std::string, std::weak_ptr<TextureImage>> images_;
  std::uint64_t shared_ = 0;
};

}  // namespace tessera::render
