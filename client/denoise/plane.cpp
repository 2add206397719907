#include "denoise/plane.h"

#include <algorithm>

#include "import/input/parallel.h"

namespace tessera::client {

void Plane::extend() {
  for (int y = 0; y < height_; ++y) {
    std::fill(at(-kMargin, y), at(0, y), *at(0, y));
    float* const end = values_.data() + offset(-kMargin, y) + stride_;
    std::fill(at(width_, y), end, *at(width_ - 1, y));
  }
  for (int y = -kMargin; y < height_ + kMargin; ++y) {
    if (y >= 0 && y < height_) continue;
    std::copy_n(at(-kMargin, std::clamp(y, 0, height_ - 1)), stride_, at(-kMargin, y));
  }
}

Plane box_mean(const Plane& plane, int radius, int threads) {
  const int width = plane.width(), height = plane.height();
  Plane rows(width, height), result(width, height);
  const auto each_row = [&](auto&& work) {
    parallel_for(static_cast<std::size_t>(height), threads,
                 [&](std::size_t y) { work(static_cast<int>(y)); });
  };
  each_row([&](int y) {
    for (int x = 0; x < width; ++x) {
      const int first = std::max(x - radius, 0), last = std::min(x + radius, width - 1);
      double sum = 0;
      for (int k = first; k <= last; ++k) sum += *plane.at(k, y);
      *rows.at(x, y) = static_cast<float>(sum / (last - first + 1));
    }
  });
  each_row([&](int y) {
    const int first = std::max(y - radius, 0), last = std::min(y + radius, height - 1);
    const float share = 1.0f / static_cast<float>(last - first + 1);
    float* const to = result.at(0, y);
    for (int k = first; k <= last; ++k) {
      const float* const from = rows.at(0, k);
      for (int x = 0; x < width; ++x) to[x] += from[x] * share;
    }
  });
  result.extend();
  return result;
}

}  // namespace tessera::client
