#include "store/file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <utility>

#include "absl/strings/str_cat.h"

namespace tessera::server {
namespace {

absl::Status errno_status(const char* what, const std::filesystem::path& path) {
  const std::string message = absl::StrCat(what, " ", path.string());
  if (errno == EIO) return absl::DataLossError(absl::StrCat(message, ": the disk fails"));
  return errno == ENOSPC || errno == EDQUOT
             ? absl::ResourceExhaustedError(absl::StrCat(message, ": the disk is full"))
             : absl::ErrnoToStatus(errno, message);
}

}  // namespace

File::File(int descriptor, std::filesystem::path path) : descriptor_(descriptor), path_(std::move(path)) {}

File::File(File&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)), path_(std::move(other.path_)) {}

File& File::operator=(File&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  std::swap(path_, other.path_);
  return *this;
}

File::~File() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

absl::StatusOr<File> File::open_or_create(const std::filesystem::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (descriptor < 0) return errno_status("open", path);
  return File(descriptor, path);
}

absl::StatusOr<File> File::open_existing(const std::filesystem::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return errno_status("open", path);
  return File(descriptor, path);
}

absl::StatusOr<File> File::in_memory() {
  const int descriptor = ::memfd_create("tessera", MFD_CLOEXEC);
  if (descriptor < 0) return errno_status("make", "a file in memory");
  return File(descriptor, "(memory)");
}

absl::Status File::error(const char* what) const { return errno_status(what, path_); }

absl::StatusOr<std::uint64_t> File::size() const {
  struct stat info {};
  if (::fstat(descriptor_, &info) != 0) return error("look at");
  return static_cast<std::uint64_t>(info.st_size);
}

absl::Status File::write_at(std::uint64_t offset, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return error("write");
    bytes.remove_prefix(static_cast<std::size_t>(written));
    offset += static_cast<std::uint64_t>(written);
  }
  return absl::OkStatus();
}

absl::Status File::read_at(std::uint64_t offset, char* out, std::size_t size) const {
  while (size > 0) {
    const ssize_t got = ::pread(descriptor_, out, size, static_cast<off_t>(offset));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return error("read");
    if (got == 0)
      return absl::DataLossError(absl::StrCat(path_.string(), " ends at ", offset, ", too early"));
    out += got;
    size -= static_cast<std::size_t>(got);
    offset += static_cast<std::uint64_t>(got);
  }
  return absl::OkStatus();
}

absl::Status File::truncate(std::uint64_t size) {
  return ::ftruncate(descriptor_, static_cast<off_t>(size)) == 0 ? absl::OkStatus() : error("truncate");
}

absl::Status File::sync() { return ::fdatasync(descriptor_) == 0 ? absl::OkStatus() : error("sync"); }

absl::StatusOr<DiskSpace> disk_space(const std::filesystem::path& path) {
  struct statvfs info {};
  if (::statvfs(path.c_str(), &info) != 0) return errno_status("look at the file system of", path);
  return DiskSpace{.free_bytes = std::uint64_t{info.f_bavail} * info.f_frsize,
                   .total_bytes = std::uint64_t{info.f_blocks} * info.f_frsize,
                   .free_files = info.f_favail,
                   .total_files = info.f_files};
}

absl::Status sync_directory(const std::filesystem::path& directory) {
  const int descriptor = ::open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return errno_status("open", directory);
  const bool synced = ::fsync(descriptor) == 0;
  absl::Status status = synced ? absl::OkStatus() : errno_status("sync", directory);
  ::close(descriptor);
  return status;
}

absl::Status rename_file(const std::filesystem::path& from, const std::filesystem::path& to) {
  return std::rename(from.c_str(), to.c_str()) == 0 ? absl::OkStatus() : errno_status("rename", from);
}

absl::Status make_directory(const std::filesystem::path& directory) {
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  if (!error) return absl::OkStatus();
  return absl::ErrnoToStatus(error.value(), absl::StrCat("make directory ", directory.string()));
}

}  // namespace tessera::server
