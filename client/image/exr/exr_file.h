// A file that OpenEXRCore writes. Its C++ interface has no place for a deflate of one's own.
#pragma once

#include <OpenEXR/openexr.h>

#include <stdexcept>
#include <string>

namespace tessera::client {

/// Ends the writing of a file: the library, or the disk, has refused something.
class WriteError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class ExrFile {
 public:
  /// Throws WriteError, here and below.
  explicit ExrFile(const std::string& path);
  ~ExrFile();
  ExrFile(const ExrFile&) = delete;
  ExrFile& operator=(const ExrFile&) = delete;

  exr_context_t context() const { return context_; }
  void check(exr_result_t result) const;
  /// Writes the places of all chunks.
  void finish() { check(exr_finish(&context_)); }

 private:
  static std::int64_t write(exr_const_context_t, void* self, const void* bytes, std::uint64_t size,
                            std::uint64_t offset, exr_stream_error_func_ptr_t);
  static void note_error(exr_const_context_t context, exr_result_t, const char* message);

  const int descriptor_;
  exr_context_t context_ = nullptr;
  std::string error_;
};

}  // namespace tessera::client
