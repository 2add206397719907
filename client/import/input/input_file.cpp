#include "import/input/input_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "import/input/concat.h"

namespace tessera::client {
namespace {

// Upper bound of what a scene file inflates to: guards against a few kilobytes that claim to be everything.
constexpr std::size_t kMaxInflatedBytes = std::size_t{8} << 30;

absl::Status system_error(const std::filesystem::path& path, int error) {
  const std::string text = concat(path.string(), ": ", std::strerror(error));
  if (error == ENOENT || error == ENOTDIR) return absl::NotFoundError(text);
  if (error == EACCES || error == EPERM) return absl::PermissionDeniedError(text);
  return absl::InvalidArgumentError(text);
}

/// A zlib stream that is always released.
struct Inflater {
  z_stream stream{};
  // 15 bits of window, plus 32: detect gzip or zlib headers.
  bool ready = inflateInit2(&stream, 15 + 32) == Z_OK;
  ~Inflater() { inflateEnd(&stream); }
};

absl::StatusOr<std::string> inflate_gzip(std::string_view compressed, const std::string& name) {
  Inflater inflater;
  if (!inflater.ready) return absl::ResourceExhaustedError("zlib cannot start");
  z_stream& stream = inflater.stream;
  std::string result;
  std::string chunk(std::size_t{1} << 18, '\0');
  for (;;) {
    if (stream.avail_in == 0) {
      const std::size_t take = std::min(compressed.size(), std::size_t{1} << 30);
      stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(compressed.data()));
      stream.avail_in = static_cast<uInt>(take);
      compressed.remove_prefix(take);
    }
    stream.next_out = reinterpret_cast<Bytef*>(chunk.data());
    stream.avail_out = static_cast<uInt>(chunk.size());
    const int state = inflate(&stream, Z_NO_FLUSH);
    result.append(chunk, 0, chunk.size() - stream.avail_out);
    if (result.size() > kMaxInflatedBytes) {
      return absl::InvalidArgumentError(
          concat(name, ": inflates to more than ", kMaxInflatedBytes, " bytes"));
    }
    const bool input_used_up = stream.avail_in == 0 && compressed.empty();
    if (state == Z_STREAM_END) {
      if (input_used_up) return result;
      inflateReset(&stream);  // gzip members may follow one another
    } else if ((state != Z_OK && state != Z_BUF_ERROR) || (input_used_up && stream.avail_out > 0)) {
      return absl::InvalidArgumentError(concat(name, ": gzip data is damaged or cut off"));
    }
  }
}

}  // namespace

InputFile::~InputFile() {
  if (mapped_ != nullptr) munmap(mapped_, mapped_size_);
}

InputFile::InputFile(InputFile&& other) noexcept
    : mapped_(std::exchange(other.mapped_, nullptr)),
      mapped_size_(std::exchange(other.mapped_size_, 0)),
      owned_(std::move(other.owned_)) {}

InputFile& InputFile::operator=(InputFile&& other) noexcept {
  std::swap(mapped_, other.mapped_);
  std::swap(mapped_size_, other.mapped_size_);
  owned_.swap(other.owned_);
  return *this;
}

absl::StatusOr<InputFile> InputFile::map(const std::filesystem::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return system_error(path, errno);
  struct stat info {};
  if (fstat(descriptor, &info) != 0) {
    const int error = errno;
    ::close(descriptor);
    return system_error(path, error);
  }
  InputFile file;
  if (S_ISREG(info.st_mode) && info.st_size > 0) {
    void* address =
        mmap(nullptr, static_cast<std::size_t>(info.st_size), PROT_READ, MAP_PRIVATE, descriptor, 0);
    if (address == MAP_FAILED) {
      const int error = errno;
      ::close(descriptor);
      return system_error(path, error);
    }
    file.mapped_ = static_cast<char*>(address);
    file.mapped_size_ = static_cast<std::size_t>(info.st_size);
  }
  ::close(descriptor);
  if (!S_ISREG(info.st_mode))
    return absl::InvalidArgumentError(concat(path.string(), ": not a regular file"));
  return file;
}

absl::StatusOr<InputFile> InputFile::open(const std::filesystem::path& path) {
  absl::StatusOr<InputFile> file = map(path);
  if (!file.ok() || path.extension() != ".gz") return file;
  absl::StatusOr<std::string> inflated = inflate_gzip(file->bytes(), path.string());
  if (!inflated.ok()) return inflated.status();
  InputFile result;
  result.owned_ = *std::move(inflated);
  return result;
}

}  // namespace tessera::client
