#include "agent/stores/mapped_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string_view>

#include "absl/strings/str_cat.h"

namespace tessera::agent {

OpenFile::~OpenFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

absl::Status file_error(const char* what, const std::filesystem::path& path) {
  const std::string message = absl::StrCat("cannot ", what, " ", path.string());
  switch (errno) {
    case EIO:
      return absl::DataLossError(absl::StrCat(message, ": the disk fails"));
    // Not ResourceExhausted or Unavailable: those come from the coordinator, and pass when one waits.
    case ENOSPC:
    case EDQUOT:
    case EFBIG:
      return absl::FailedPreconditionError(absl::StrCat(message, ": the disk is full"));
    case EROFS:
    case ENOMEM:
    case EMFILE:
    case ENFILE: {
      const int error = errno;
      return absl::FailedPreconditionError(absl::StrCat(message, ": ", std::strerror(error)));
    }
    default:
      return absl::ErrnoToStatus(errno, message);
  }
}

absl::StatusOr<render::BlobBytes> map_file(const OpenFile& file, const std::filesystem::path& path) {
  struct stat info {};
  if (::fstat(file.get(), &info) != 0) return file_error("examine", path);
  const auto size = static_cast<std::size_t>(info.st_size);
  if (size == 0) return render::BlobBytes{};
  void* const address = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file.get(), 0);
  if (address == MAP_FAILED) return file_error("map", path);
  std::shared_ptr<const void> owner{
      address, [size](const void* mapped) { ::munmap(const_cast<void*>(mapped), size); }};
  return render::BlobBytes{std::string_view{static_cast<const char*>(address), size}, std::move(owner)};
}

absl::StatusOr<render::BlobBytes> map_file(const std::filesystem::path& path) {
  const OpenFile file{::open(path.c_str(), O_RDONLY | O_CLOEXEC)};
  if (!file.is_open()) return file_error("open", path);
  return map_file(file, path);
}

}  // namespace tessera::agent
