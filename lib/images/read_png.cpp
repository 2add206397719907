#include <png.h>

#include <csetjmp>
#include <cstring>

#include "images/readers.h"

namespace tessera::images {
namespace {

struct Source {
  const char* next;
  std::size_t left;
};

void take(png_structp png, png_bytep to, std::size_t count) {
  auto& source = *static_cast<Source*>(png_get_io_ptr(png));
  if (count > source.left) png_error(png, "the file ends early");
  std::memcpy(to, source.next, count);
  source.next += count;
  source.left -= count;
}

[[noreturn]] void escape(png_structp png, png_const_charp) { png_longjmp(png, 1); }
void ignore(png_structp, png_const_charp) {}

/// Everything between setjmp and the last call that may jump there: no object with a destructor lives here.
bool read(png_structp png, png_infop info, Source& source, std::uint64_t max_pixels, ImagePixels& pixels) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_set_read_fn(png, &source, take);
  png_read_info(png, info);
  if (png_get_bit_depth(png, info) > 8) return false;
  if (!allot(png_get_image_width(png, info), png_get_image_height(png, info), false, max_pixels, pixels))
    return false;
  png_set_expand(png);
  png_set_gray_to_rgb(png);
  png_set_filler(png, 0xff, PNG_FILLER_AFTER);
  const int passes = png_set_interlace_handling(png);
  png_read_update_info(png, info);
  if (png_get_rowbytes(png, info) != 4 * static_cast<std::size_t>(pixels.size.width)) return false;
  for (int pass = 0; pass < passes; ++pass) {
    png_bytep row = reinterpret_cast<png_bytep>(pixels.bytes.data());
    for (std::int32_t y = 0; y < pixels.size.height;
         ++y, row += 4 * static_cast<std::size_t>(pixels.size.width)) {
      png_read_row(png, row, nullptr);
    }
  }
  png_read_end(png, nullptr);
  return true;
}

}  // namespace

bool read_png(std::string_view blob, std::uint64_t max_pixels, ImagePixels& pixels) {
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, escape, ignore);
  if (png == nullptr) return false;
  png_infop info = png_create_info_struct(png);
  Source source{blob.data(), blob.size()};
  const bool whole = info != nullptr && read(png, info, source, max_pixels, pixels);
  png_destroy_read_struct(&png, &info, nullptr);
  return whole;
}

}  // namespace tessera::images
