#include "image/png.h"

#include <png.h>

#include <array>
#include <cerrno>
#include <cmath>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <optional>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "image/atomic_file.h"
#include "image/color_space.h"

namespace tessera::client {

unsigned char srgb_byte(float linear) {
  if (!(linear > 0)) return 0;  // NaN too
  if (linear >= 1) return 255;
  const float encoded = linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1 / 2.4f) - 0.055f;
  return static_cast<unsigned char>(std::lround(255 * encoded));
}

namespace {

/// A file that libpng writes, which reports errors by a jump: what is called behind guarded() has nothing to
/// destroy.
class PngFile {
 public:
  PngFile() : png_(png_create_write_struct(PNG_LIBPNG_VER_STRING, this, &fail, &ignore)) {}
  ~PngFile() {
    png_destroy_write_struct(&png_, &info_);
    if (file_ != nullptr) std::fclose(file_);
  }
  PngFile(const PngFile&) = delete;
  PngFile& operator=(const PngFile&) = delete;

  bool open(const std::string& path, const Window& window) {
    if (png_ == nullptr || (info_ = png_create_info_struct(png_)) == nullptr)
      return set_error("out of memory");
    if ((file_ = std::fopen(path.c_str(), "wb")) == nullptr) return set_error(std::strerror(errno));
    return guarded([&] {
      png_init_io(png_, file_);
      png_set_IHDR(png_, info_, static_cast<png_uint_32>(window.width()),
                   static_cast<png_uint_32>(window.height()), 8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
                   PNG_COMPRESSION_TYPE_BASE, PNG_FILTER_TYPE_BASE);
      png_set_sRGB(png_, info_, PNG_sRGB_INTENT_PERCEPTUAL);
      png_write_info(png_, info_);
    });
  }
  bool write(const std::vector<unsigned char>& row) {
    return guarded([&] { png_write_row(png_, row.data()); });
  }
  bool close() {
    if (!guarded([&] { png_write_end(png_, nullptr); })) return false;
    std::FILE* const file = std::exchange(file_, nullptr);
    return std::fclose(file) == 0 || set_error(std::strerror(errno));
  }
  const char* error() const { return error_; }

 private:
  static void fail(png_structp png, png_const_charp message) {
    static_cast<PngFile*>(png_get_error_ptr(png))->set_error(message);
    png_longjmp(png, 1);
  }
  static void ignore(png_structp, png_const_charp) {}

  bool set_error(const char* message) {
    std::snprintf(error_, sizeof(error_), "%s", message);
    return false;
  }
  template <class Step>
  bool guarded(const Step& step) {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    step();
    return true;
  }

  png_structp png_;
  png_infop info_ = nullptr;
  std::FILE* file_ = nullptr;
  char error_[256] = "";
};

absl::Status write_rows(const Image& image, Rows& rows, const std::string& path, const std::string& file) {
  const auto error = [&](const PngFile& png) {
    return absl::InternalError(absl::StrCat(path, ": cannot write: ", png.error()));
  };
  const auto width = static_cast<std::size_t>(image.data.width());
  const std::array<std::size_t, 3> channels = rgb_channels(image);
  const std::optional<spectra::Matrix3> rec709 = rec709_from(image);
  std::array<std::vector<float>, 3> row;
  row.fill(std::vector<float>(width));
  std::vector<unsigned char> bytes(3 * width);
  PngFile png;
  if (!png.open(file, image.data)) return error(png);
  for (std::int32_t y = 0; y < image.data.height(); ++y) {
    for (std::size_t c = 0; c < 3; ++c) {
      if (absl::Status status = rows.read(channels[c], y, row[c]); !status.ok()) return status;
    }
    for (std::size_t x = 0; x < width; ++x) {
      spectra::Triple color = {row[0][x], row[1][x], row[2][x]};
      if (rec709) color = spectra::times(*rec709, color);
      for (std::size_t c = 0; c < 3; ++c) bytes[3 * x + c] = srgb_byte(static_cast<float>(color[c]));
    }
    if (!png.write(bytes)) return error(png);
  }
  return png.close() ? absl::OkStatus() : error(png);
}

}  // namespace

absl::Status write_png(const Image& image, const std::string& path) {
  ImageRows rows(image);
  return write_png(image, rows, path);
}

absl::Status write_png(const Image& image, Rows& rows, const std::string& path) {
  if (image.channels.empty() || image.pixel_count() == 0)
    return absl::InvalidArgumentError(absl::StrCat(path, ": the image is empty"));
  return replace_file(path, [&](const std::string& file) { return write_rows(image, rows, path, file); });
}

}  // namespace tessera::client
