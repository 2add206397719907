// Planes of a picture with room around them, for windows that reach over its edge.
#pragma once

#include <cstddef>
#include <vector>

namespace tessera::client {

/// Windows and patches reach so many pixels beyond the picture at most.
inline constexpr int kMargin = 16;

/// Rows from the top, of `stride` floats; at() is valid within the margin, and 16 floats further right.
class Plane {
 public:
  Plane() = default;
  Plane(int width, int height)
      : width_(width),
        height_(height),
        stride_((width + 2 * kMargin + 15) / 16 * 16 + 16),
        values_(static_cast<std::size_t>(stride_) * static_cast<std::size_t>(height + 2 * kMargin) + 16) {}

  int width() const { return width_; }
  int height() const { return height_; }
  int stride() const { return stride_; }
  float* at(int x, int y) { return values_.data() + offset(x, y); }
  const float* at(int x, int y) const { return values_.data() + offset(x, y); }

  /// Repeats the picture's edge in the margin.
  void extend();

 private:
  std::size_t offset(int x, int y) const {
    return static_cast<std::size_t>(y + kMargin) * static_cast<std::size_t>(stride_) +
           static_cast<std::size_t>(x + kMargin);
  }

  int width_ = 0, height_ = 0, stride_ = 0;
  std::vector<float> values_;
};

/// Means over squares of 2 * radius + 1 pixels, cut at the picture's edge; with its margin. Rows are shared
/// out among `threads`.
Plane box_mean(const Plane& plane, int radius, int threads);

}  // namespace tessera::client
