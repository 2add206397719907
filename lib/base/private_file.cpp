#include "base/private_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "absl/strings/str_cat.h"

namespace tessera::base {
namespace {

namespace fs = std::filesystem;

absl::Status file_error(const fs::path& path) {
  return absl::UnavailableError(absl::StrCat(path.string(), ": ", std::strerror(errno)));
}

bool write_all(int descriptor, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

}  // namespace

absl::Status replace_file(const fs::path& path, mode_t mode, std::string_view bytes) {
  const fs::path draft = path.string() + ".new";
  ::unlink(draft.c_str());
  const int descriptor = ::open(draft.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
  if (descriptor < 0) return file_error(draft);
  absl::Status status;
  if (!write_all(descriptor, bytes) || ::fsync(descriptor) != 0) status = file_error(draft);
  ::close(descriptor);
  if (!status.ok()) return status;
  if (::rename(draft.c_str(), path.c_str()) != 0) return file_error(path);
  const fs::path folder = path.has_parent_path() ? path.parent_path() : ".";
  const int directory = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (directory < 0) return file_error(folder);
  if (::fsync(directory) != 0) status = file_error(folder);
  ::close(directory);
  return status;
}

absl::Status make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return absl::UnavailableError(absl::StrCat(folder.string(), ": ", error.message()));
  return absl::OkStatus();
}

}  // namespace tessera::base
