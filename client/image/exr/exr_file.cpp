#include "image/exr/exr_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace tessera::client {

ExrFile::ExrFile(const std::string& path)
    : descriptor_(::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666)) {
  if (descriptor_ < 0) throw WriteError(std::strerror(errno));
  exr_context_initializer_t how = EXR_DEFAULT_CONTEXT_INITIALIZER;
  how.user_data = this;
  how.write_fn = &ExrFile::write;
  how.error_handler_fn = &ExrFile::note_error;
  const exr_result_t started = exr_start_write(&context_, path.c_str(), EXR_WRITE_FILE_DIRECTLY, &how);
  if (started == EXR_ERR_SUCCESS) return;
  ::close(descriptor_);
  throw WriteError(error_.empty() ? exr_get_default_error_message(started) : error_);
}

ExrFile::~ExrFile() {
  if (context_ != nullptr) static_cast<void>(exr_finish(&context_));
  ::close(descriptor_);
}

void ExrFile::check(exr_result_t result) const {
  if (result != EXR_ERR_SUCCESS)
    throw WriteError(error_.empty() ? exr_get_default_error_message(result) : error_);
}

std::int64_t ExrFile::write(exr_const_context_t, void* self, const void* bytes, std::uint64_t size,
                            std::uint64_t offset, exr_stream_error_func_ptr_t) {
  ExrFile& file = *static_cast<ExrFile*>(self);
  for (std::uint64_t done = 0; done < size;) {
    const ssize_t written = ::pwrite(file.descriptor_, static_cast<const char*>(bytes) + done, size - done,
                                     static_cast<off_t>(offset + done));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) {
      file.error_ = std::strerror(written < 0 ? errno : ENOSPC);
      return -1;
    }
    done += static_cast<std::uint64_t>(written);
  }
  return static_cast<std::int64_t>(size);
}

void ExrFile::note_error(exr_const_context_t context, exr_result_t, const char* message) {
  void* self = nullptr;
  if (context == nullptr || exr_get_user_data(context, &self) != EXR_ERR_SUCCESS || self == nullptr) return;
  std::string& error = static_cast<ExrFile*>(self)->error_;
  if (error.empty()) error = message;  // the first one is the cause
}

}  // namespace tessera::client
