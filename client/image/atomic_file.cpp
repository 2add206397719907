#include "image/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <system_error>

#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"

namespace tessera::client {
namespace {

absl::Status errno_status(const std::string& what, const std::string& path) {
  return absl::ErrnoToStatus(errno, absl::StrCat(path, ": ", what));
}

// Creates an empty file in the same directory as `path`, for rename works within one file system only.
absl::StatusOr<std::string> make_temporary(const std::string& path) {
  constexpr int kAttempts = 100;  // left-over files of killed processes may be in the way
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    std::string name = absl::StrCat(path, ".part-", getpid(), "-", attempt);
    const int fd = open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (fd >= 0) {
      close(fd);
      return name;
    }
    if (errno != EEXIST) break;
  }
  return errno_status("cannot create a file there", path);
}

absl::Status sync_file(const std::string& temporary, const std::string& path) {
  const int fd = open(temporary.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return errno_status("cannot reopen to flush", path);
  absl::Status status;
  if (fsync(fd) != 0) status = errno_status("cannot flush to disk", path);
  close(fd);
  return status;
}

// `path` is the name to report.
absl::Status write_bytes(const std::string& file, std::string_view bytes, const std::string& path) {
  const int fd = open(file.c_str(), O_WRONLY | O_TRUNC | O_CLOEXEC);
  if (fd < 0) return errno_status("cannot open for writing", path);
  absl::Status status;
  while (!bytes.empty() && status.ok()) {
    const ssize_t written = ::write(fd, bytes.data(), bytes.size());
    if (written >= 0) {
      bytes.remove_prefix(static_cast<std::size_t>(written));
    } else if (errno != EINTR) {
      status = errno_status("cannot write", path);
    }
  }
  if (close(fd) != 0 && status.ok()) status = errno_status("cannot close", path);
  return status;
}

}  // namespace

std::string link_target(const std::string& path) {
  constexpr int kMostLinks = 40;  // Linux follows no more
  std::filesystem::path target = path;
  std::error_code error;
  for (int i = 0; i < kMostLinks && std::filesystem::is_symlink(target, error); ++i) {
    // One that is relative begins where the link lies.
    target = target.parent_path() / std::filesystem::read_symlink(target, error);
    if (error) return path;
  }
  return target.string();
}

absl::Status replace_file(const std::string& name,
                          const std::function<absl::Status(const std::string&)>& write) {
  const std::string path = link_target(name);
  struct stat existing {};
  if (stat(path.c_str(), &existing) == 0 && !S_ISREG(existing.st_mode)) {
    if (S_ISDIR(existing.st_mode)) return absl::InvalidArgumentError(absl::StrCat(path, ": is a directory"));
    return write(path);
  }

  absl::StatusOr<std::string> temporary = make_temporary(path);
  if (!temporary.ok()) return temporary.status();
  absl::Status status = write(*temporary);
  if (status.ok()) status = sync_file(*temporary, path);
  if (status.ok() && std::rename(temporary->c_str(), path.c_str()) != 0)
    status = errno_status("cannot rename", path);
  if (!status.ok()) unlink(temporary->c_str());
  return status;
}

absl::Status replace_file_with(const std::string& path, std::string_view bytes) {
  return replace_file(path, [&](const std::string& file) { return write_bytes(file, bytes, path); });
}

}  // namespace tessera::client
