#include "image/png.h"

#include <png.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "image/atomic_file.h"
#include "image/color_space.h"

namespace tessera::client {

namespace {

/// `rounding` is added before the code is cut to a whole one.
unsigned char byte_of(double code, double rounding) {
  if (!(code > 0)) return 0;  // NaN too
  return static_cast<unsigned char>(std::min(255.0, std::floor(255 * static_cast<float>(code) + rounding)));
}

}  // namespace

unsigned char srgb_byte(float linear) { return byte_of(srgb_encoded(linear), 0.5); }

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

/// A half, or a pixel's threshold from 0 to 1, another one for each channel.
double rounding(bool dithers, std::size_t x, std::int32_t y, std::size_t channel) {
  if (!dithers) return 0.5;
  // One over the plastic number and its square; channels are far apart in the sequence.
  constexpr double kAlongX = 0.7548776662466927, kAlongY = 0.5698402909980532;
  const double place =
      kAlongX * static_cast<double>(x + 37 * channel) + kAlongY * (y + 17.0 * static_cast<double>(channel));
  return place - std::floor(place);
}

absl::Status write_rows(const Image& image, Rows& rows, const ViewOptions& options, const DisplayView& view,
                        const std::string& path, const std::string& file) {
  const auto error = [&](const PngFile& png) {
    return absl::InternalError(absl::StrCat(path, ": cannot write: ", png.error()));
  };
  const auto width = static_cast<std::size_t>(image.data.width());
  const std::array<std::size_t, 3> channels = rgb_channels(image);
  const std::optional<spectra::Matrix3> rec709 =
      view.takes_rec709() ? rec709_from(image) : std::optional<spectra::Matrix3>();
  const double exposure = std::exp2(options.exposure_stops);
  std::array<std::vector<float>, 3> row;
  row.fill(std::vector<float>(width));
  std::vector<spectra::Triple> colors(width);
  std::vector<unsigned char> bytes(3 * width);
  PngFile png;
  if (!png.open(file, image.data)) return error(png);
  for (std::int32_t y = 0; y < image.data.height(); ++y) {
    for (std::size_t c = 0; c < 3; ++c) {
      if (absl::Status status = rows.read(channels[c], y, row[c]); !status.ok()) return status;
    }
    for (std::size_t x = 0; x < width; ++x) {
      colors[x] = {exposure * row[0][x], exposure * row[1][x], exposure * row[2][x]};
      if (rec709) colors[x] = spectra::times(*rec709, colors[x]);
    }
    view.show(colors);
    for (std::size_t x = 0; x < width; ++x) {
      for (std::size_t c = 0; c < 3; ++c)
        bytes[3 * x + c] = byte_of(colors[x][c], rounding(options.dithers, x, y, c));
    }
    if (!png.write(bytes)) return error(png);
  }
  return png.close() ? absl::OkStatus() : error(png);
}

}  // namespace

absl::Status write_png(const Image& image, const std::string& path, const ViewOptions& view) {
  ImageRows rows(image);
  return write_png(image, rows, path, view);
}

absl::Status write_png(const Image& image, Rows& rows, const std::string& path, const ViewOptions& options) {
  if (image.channels.empty() || image.pixel_count() == 0)
    return absl::InvalidArgumentError(absl::StrCat(path, ": the image is empty"));
  const absl::StatusOr<std::unique_ptr<DisplayView>> view = make_display_view(options);
  if (!view.ok()) return view.status();
  return replace_file(
      path, [&](const std::string& file) { return write_rows(image, rows, options, **view, path, file); });
}

}  // namespace tessera::client
