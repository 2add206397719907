#include "command/report/output.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "image/atomic_file.h"
#include "image/png.h"

namespace tessera::client {
namespace fs = std::filesystem;
namespace {

std::string extension_of(const std::string& path) {
  std::string extension = fs::path{path}.extension().string();
  absl::AsciiStrToLower(&extension);
  return extension;
}

}  // namespace

absl::Status check_output(const std::string& path) {
  const std::string extension = extension_of(path);
  if (extension != ".exr" && extension != ".png") {
    return absl::InvalidArgumentError(absl::StrCat("'", path, "' ends neither in .exr nor in .png"));
  }
  return check_writable(path);
}

absl::Status check_output(const std::string& path, const ExrFormat& exr) {
  absl::Status status = check_output(path);
  if (status.ok() && exr.multiview && !is_exr(path))
    status = absl::InvalidArgumentError(absl::StrCat("--multiview writes an .exr; '", path, "' is none"));
  return status;
}

absl::Status check_writable(const std::string& path) {
  const auto no = [&](const std::string& why) {
    return absl::InvalidArgumentError(absl::StrCat("cannot write ", path, ": ", why));
  };
  if (fs::is_directory(path)) return no("it is a directory");
  const fs::path folder = fs::path{link_target(path)}.parent_path();
  const std::string name = folder.empty() ? "." : folder.string();
  if (!fs::exists(name)) return no(absl::StrCat("there is no folder ", name));
  if (::access(name.c_str(), W_OK) != 0) return no(absl::StrCat(name, ": ", std::strerror(errno)));
  return absl::OkStatus();
}

bool is_exr(const std::string& path) { return extension_of(path) == ".exr"; }

absl::Status write_image(const Image& image, const std::string& path, const ExrFormat& exr,
                         const ViewOptions& view) {
  if (extension_of(path) == ".png") return write_png(image, path, view);
  return write_exr(image, path, exr);
}

absl::Status write_image(const Image& image, Rows& rows, const std::string& path, const ExrFormat& exr) {
  if (extension_of(path) == ".png") return write_png(image, rows, path);
  return write_exr(image, rows, path, exr);
}

}  // namespace tessera::client
