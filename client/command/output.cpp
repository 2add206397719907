#include "command/output.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "absl/strings/str_cat.h"
#include "image/exr.h"
#include "image/png.h"

namespace tessera::client {
namespace fs = std::filesystem;

absl::Status check_output(const std::string& path) {
  const std::string extension = fs::path{path}.extension().string();
  if (extension != ".exr" && extension != ".png") {
    return absl::InvalidArgumentError(absl::StrCat("'", path, "' ends neither in .exr nor in .png"));
  }
  fs::path directory = fs::path{path}.parent_path();
  if (directory.empty()) directory = ".";
  if (::access(directory.c_str(), W_OK) != 0) {
    return absl::InvalidArgumentError(absl::StrCat("cannot write to ", directory.string(), ": ", std::strerror(errno)));
  }
  if (fs::is_directory(path)) return absl::InvalidArgumentError(absl::StrCat("'", path, "' is a directory"));
  return absl::OkStatus();
}

absl::Status write_image(const Image& image, const std::string& path, bool half) {
  if (fs::path{path}.extension() == ".png") return write_png(image, path);
  return write_exr(image, path, half ? PixelType::kHalf : PixelType::kFloat);
}

}  // namespace tessera::client
