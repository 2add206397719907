// Where a writer takes pixels from: an image in memory, or one that is kept elsewhere.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>

#include "absl/status/status.h"
#include "image/exr.h"

namespace tessera::client {

class Rows {
 public:
  virtual ~Rows() = default;
  /// Row `y` of the data window, from its top, of plane `plane`: as many values as it is wide. Rows are asked
  /// for from the top, and again for each part.
  virtual absl::Status read(std::size_t plane, std::int32_t y, std::span<float> row) = 0;
};

/// Rows of an image that has its pixels, which outlives them.
class ImageRows final : public Rows {
 public:
  explicit ImageRows(const Image& image) : image_(image) {}

  absl::Status read(std::size_t plane, std::int32_t y, std::span<float> row) override {
    std::copy_n(image_.channels[plane].values.begin() +
                    static_cast<std::ptrdiff_t>(static_cast<std::size_t>(y) * row.size()),
                row.size(), row.begin());
    return absl::OkStatus();
  }

 private:
  const Image& image_;
};

/// write_exr() of an image whose planes have names, but no values: those are `rows`.
absl::Status write_exr(const Image& image, Rows& rows, const std::string& path, const ExrFormat& format);

struct ExrView {
  const Image* image = nullptr;
  Rows* rows = nullptr;  // null: the image has its values
};
/// Writes pictures into one file, a part each, or several: their attributes `view`, which differ, name them
/// and their parts ("rgba.left"). InvalidArgument where one has none.
absl::Status write_exr_views(std::span<const ExrView> views, const std::string& path,
                             const ExrFormat& format);

}  // namespace tessera::client
