// Files as memory.
#pragma once

#include <filesystem>
#include <utility>

#include "absl/status/statusor.h"
#include "render/scene/load_scene.h"

namespace tessera::agent {

/// A file descriptor that closes itself; -1 for none.
class OpenFile {
 public:
  explicit OpenFile(int descriptor) : descriptor_(descriptor) {}
  OpenFile(OpenFile&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  OpenFile& operator=(OpenFile&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    return *this;
  }
  ~OpenFile();

  int get() const { return descriptor_; }
  bool is_open() const { return descriptor_ >= 0; }

 private:
  int descriptor_;
};

/// The status of `errno`: "cannot open /a/b: Permission denied".
absl::Status file_error(const char* what, const std::filesystem::path& path);

/// The whole file, read-only, for as long as the result's owner lives. `path` is for messages.
absl::StatusOr<render::BlobBytes> map_file(const OpenFile& file, const std::filesystem::path& path);
absl::StatusOr<render::BlobBytes> map_file(const std::filesystem::path& path);

}  // namespace tessera::agent
