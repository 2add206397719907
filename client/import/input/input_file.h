// The bytes of a file, mapped; gzip files are inflated.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace tessera::client {

/// A whole file in memory, read-only. Mapped where that is possible, so that opening costs nothing.
class InputFile {
 public:
  /// NotFound or PermissionDenied with the path; InvalidArgument for a directory or damaged gzip data. A name
  /// that ends in ".gz" is inflated.
  static absl::StatusOr<InputFile> open(const std::filesystem::path& path);

  InputFile() = default;
  ~InputFile();
  InputFile(InputFile&& other) noexcept;
  InputFile& operator=(InputFile&& other) noexcept;

  std::string_view bytes() const {
    return mapped_ != nullptr ? std::string_view(mapped_, mapped_size_) : owned_;
  }

 private:
  static absl::StatusOr<InputFile> map(const std::filesystem::path& path);

  char* mapped_ = nullptr;
  std::size_t mapped_size_ = 0;
  std::string owned_;
};

}  // namespace tessera::client
