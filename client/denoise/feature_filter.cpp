#include "denoise/feature_filter.h"

#include <algorithm>

#include "denoise/kernel/kernel.h"
#include "denoise/noisy_picture.h"
#include "import/input/parallel.h"

namespace tessera::client::denoise {
namespace {

constexpr int kSearchRadius = 5;
constexpr int kFeaturePatchRadius = 1;  // features have sharp edges, and little noise
constexpr int kRowsTogether = 16;

}  // namespace

std::vector<Plane> filter_features(const std::vector<Plane>& features, const std::vector<Plane>& variances,
                                   const Plane& inside, int threads) {
  const int width = features[0].width(), height = features[0].height();
  const int channels = static_cast<int>(features.size());
  PatchTask task{
      .channels = channels, .value = {}, .variance = {}, .usual = {}, .patch_radius = kFeaturePatchRadius};
  set_views(features, task.value);
  set_views(variances, task.variance);
  set_views(variances, task.usual);
  std::vector<Plane> filtered(features.size(), Plane(width, height));

  const auto filter_rows = [&](std::size_t index) {
    const int begin = static_cast<int>(index) * kRowsTogether, end = std::min(begin + kRowsTogether, height);
    const auto stride = static_cast<std::size_t>(width) + 16;
    std::vector<float> distance(stride),
        scratch((2 * kFeaturePatchRadius + 1) * (static_cast<std::size_t>(width) + 48));
    std::vector<float> weights(stride * kRowsTogether), sums(weights.size() * features.size());
    for (int dy = -kSearchRadius; dy <= kSearchRadius; ++dy) {
      for (int dx = -kSearchRadius; dx <= kSearchRadius; ++dx) {
        for (int y = begin; y < end; ++y) {
          kernel().patch_row(task, y, dx, dy, width, y == begin ? 2 * kFeaturePatchRadius + 1 : 1,
                             scratch.data(), distance.data());
          const std::size_t row = static_cast<std::size_t>(y - begin) * stride;
          float* to[3];
          for (std::size_t c = 0; c < features.size(); ++c) to[c] = &sums[c * weights.size() + row];
          kernel().blend_row(task.value, channels, view(inside), y, dx, dy, width, distance.data(), to,
                             &weights[row]);
        }
      }
    }
    for (int y = begin; y < end; ++y) {
      for (int x = 0; x < width; ++x) {
        const std::size_t at = static_cast<std::size_t>(y - begin) * stride + static_cast<std::size_t>(x);
        for (std::size_t c = 0; c < features.size(); ++c)
          *filtered[c].at(x, y) = sums[c * weights.size() + at] / weights[at];
      }
    }
  };
  parallel_for(static_cast<std::size_t>((height + kRowsTogether - 1) / kRowsTogether), threads, filter_rows);
  for (Plane& plane : filtered) plane.extend();
  return filtered;
}

}  // namespace tessera::client::denoise
