#include <csetjmp>
#include <cstdio>

#include <jpeglib.h>

#include "images/readers.h"

namespace tessera::images {
namespace {

struct ErrorHandler {
  jpeg_error_mgr base;  // first: libjpeg knows this alone
  std::jmp_buf escape;
};

[[noreturn]] void escape(j_common_ptr info) {
  std::longjmp(reinterpret_cast<ErrorHandler*>(info->err)->escape, 1);
}
void ignore(j_common_ptr) {}

/// Everything between setjmp and the last call that may jump there: no object with a destructor lives here.
bool read(jpeg_decompress_struct& info, ErrorHandler& errors, std::string_view blob, std::uint64_t max_pixels,
          ImagePixels& pixels) {
  if (setjmp(errors.escape) != 0) return false;
  jpeg_mem_src(&info, reinterpret_cast<const unsigned char*>(blob.data()), blob.size());
  if (jpeg_read_header(&info, TRUE) != JPEG_HEADER_OK) return false;
  if (info.num_components != 1 && info.num_components != 3) return false;
  if (!allot(info.image_width, info.image_height, false, max_pixels, pixels)) return false;
  info.out_color_space = JCS_EXT_RGBA;
  jpeg_start_decompress(&info);
  while (info.output_scanline < info.output_height) {
    JSAMPROW row = reinterpret_cast<JSAMPROW>(pixels.bytes.data() + std::size_t{info.output_scanline} *
                                                                        std::size_t{info.output_width});
    jpeg_read_scanlines(&info, &row, 1);
  }
  jpeg_finish_decompress(&info);
  return errors.base.num_warnings == 0;
}

}  // namespace

bool read_jpeg(std::string_view blob, std::uint64_t max_pixels, ImagePixels& pixels) {
  jpeg_decompress_struct info{};
  ErrorHandler errors{};
  info.err = jpeg_std_error(&errors.base);
  errors.base.error_exit = escape;
  errors.base.output_message = ignore;
  jpeg_create_decompress(&info);
  const bool whole = read(info, errors, blob, max_pixels, pixels);
  jpeg_destroy_decompress(&info);
  return whole;
}

}  // namespace tessera::images
