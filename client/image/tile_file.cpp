#include "image/tile_file.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "image/hole_marker.h"

namespace tessera::client {
namespace {

absl::Status fault(const char* what, int error) {
  return absl::InternalError(
      absl::StrCat("temporary file for the frame: cannot ", what, ": ", std::strerror(error)));
}

/// Reads or writes all bytes, at their place.
template <class Byte, class Call>
absl::Status transfer(Call call, int file, Byte* bytes, std::size_t size, std::size_t offset,
                      const char* what) {
  for (std::size_t done = 0; done < size;) {
    const ssize_t now = call(file, bytes + done, size - done, static_cast<off_t>(offset + done));
    if (now < 0 && errno == EINTR) continue;
    if (now <= 0) return fault(what, now < 0 ? errno : ENOSPC);
    done += static_cast<std::size_t>(now);
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::unique_ptr<TileFile>> TileFile::create(const Window& crop, std::int32_t tile_size,
                                                           std::size_t planes,
                                                           std::vector<std::size_t> marked) {
  std::error_code error;
  std::filesystem::path folder = std::filesystem::temp_directory_path(error);
  if (error) folder = "/tmp";
  std::string name = (folder / "tessera-frame-XXXXXX").string();
  const int file = ::mkstemp(name.data());
  if (file < 0) return fault("create", errno);
  ::unlink(name.c_str());  // it goes away with this process, however that ends
  return std::unique_ptr<TileFile>(new TileFile(file, crop, tile_size, planes, std::move(marked)));
}

TileFile::TileFile(int file, const Window& crop, std::int32_t tile_size, std::size_t planes,
                   std::vector<std::size_t> marked)
    : file_(file),
      crop_(crop),
      tile_size_(tile_size),
      planes_(planes),
      first_column_(crop.x0 / tile_size),
      first_row_(crop.y0 / tile_size),
      columns_((crop.x1 - 1) / tile_size - first_column_ + 1),
      rows_((crop.y1 - 1) / tile_size - first_row_ + 1),
      marked_(std::move(marked)),
      there_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_)),
      bands_(planes) {}

TileFile::~TileFile() { ::close(file_); }

std::size_t TileFile::index_of(std::int32_t x, std::int32_t y) const {
  return static_cast<std::size_t>(y / tile_size_ - first_row_) * static_cast<std::size_t>(columns_) +
         static_cast<std::size_t>(x / tile_size_ - first_column_);
}

Window TileFile::window_of(std::int32_t column, std::int32_t row) const {
  const std::int32_t x = (first_column_ + column) * tile_size_, y = (first_row_ + row) * tile_size_;
  return {std::max(x, crop_.x0), std::max(y, crop_.y0), std::min(x + tile_size_, crop_.x1),
          std::min(y + tile_size_, crop_.y1)};
}

bool TileFile::is_tile(const Window& pixels) const {
  return pixels == window_of(pixels.x0 / tile_size_ - first_column_, pixels.y0 / tile_size_ - first_row_);
}

absl::Status TileFile::put(const Window& pixels, std::span<const float> values) {
  const std::size_t index = index_of(pixels.x0, pixels.y0);
  const std::size_t slot =
      static_cast<std::size_t>(tile_size_) * static_cast<std::size_t>(tile_size_) * planes_ * sizeof(float);
  there_[index] = true;
  return transfer(::pwrite, file_, reinterpret_cast<const char*>(values.data()), values.size_bytes(),
                  index * slot, "write");
}

/// Marks these pixels in the band of a plane that is their row of tiles.
void TileFile::mark(const Window& pixels, std::vector<float>& band) const {
  const auto width = static_cast<std::size_t>(crop_.width());
  for (std::int32_t y = pixels.y0; y < pixels.y1; ++y) {
    for (std::int32_t x = pixels.x0; x < pixels.x1; ++x) {
      band[static_cast<std::size_t>(y - pixels.y0) * width + static_cast<std::size_t>(x - crop_.x0)] =
          hole_marker(x, y);
    }
  }
}

absl::Status TileFile::load_band(std::size_t plane, std::int32_t row) {
  Band& band = bands_[plane];
  band.tile_row = -1;
  const auto width = static_cast<std::size_t>(crop_.width());
  const auto height = static_cast<std::size_t>(window_of(0, row).height());
  band.values.assign(width * height, 0.0f);
  const std::size_t slot =
      static_cast<std::size_t>(tile_size_) * static_cast<std::size_t>(tile_size_) * planes_ * sizeof(float);
  const bool marks = std::ranges::find(marked_, plane) != marked_.end();
  std::vector<float> tile;
  for (std::int32_t column = 0; column < columns_; ++column) {
    const Window pixels = window_of(column, row);
    const std::size_t index = index_of(pixels.x0, pixels.y0);
    if (!there_[index]) {
      if (marks) mark(pixels, band.values);
      continue;
    }
    const auto tile_width = static_cast<std::size_t>(pixels.width());
    tile.resize(tile_width * height);
    const std::size_t bytes = tile.size() * sizeof(float);
    if (absl::Status status = transfer(::pread, file_, reinterpret_cast<char*>(tile.data()), bytes,
                                       index * slot + plane * bytes, "read");
        !status.ok())
      return status;
    for (std::size_t line = 0; line < height; ++line) {
      std::copy_n(tile.data() + line * tile_width, tile_width,
                  band.values.data() + line * width + static_cast<std::size_t>(pixels.x0 - crop_.x0));
    }
  }
  band.tile_row = row;
  return absl::OkStatus();
}

absl::Status TileFile::read(std::size_t plane, std::int32_t y, std::span<float> row) {
  const std::int32_t tile_row = (y + crop_.y0) / tile_size_ - first_row_;
  if (bands_[plane].tile_row != tile_row) {
    if (absl::Status status = load_band(plane, tile_row); !status.ok()) return status;
  }
  const auto line = static_cast<std::size_t>(y + crop_.y0 - window_of(0, tile_row).y0);
  std::copy_n(bands_[plane].values.data() + line * row.size(), row.size(), row.begin());
  return absl::OkStatus();
}

}  // namespace tessera::client
