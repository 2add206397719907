#include <array>
#include <iterator>

#include "denoise/kernel/kernel.h"
#include "denoise/methods.h"
#include "denoise/mixture.h"
#include "import/input/parallel.h"

namespace tessera::client::denoise {
namespace {

constexpr int kAveragingRadius = 10;
/// Squares of differences over their variance beyond which pixels are not equal. Of pixels that are, about
/// one in 200 exceeds the first and one in 4 the second, by the normal distribution; of few samples, whose
/// variance is itself uncertain, some more. Where light changes slowly, the first takes too much for equal.
constexpr float kCriticalSquares[] = {7.9f, 1.3f};

struct Averages {
  Picture first, second;
};

}  // namespace

Colours denoise_statistically(const NoisyPicture& picture, int threads) {
  std::vector<Plane> guides = picture.guides;
  for (std::size_t g = 0; g < guides.size(); ++g) {
    for (int y = -kMargin; y < picture.height + kMargin; ++y) {
      for (int x = -kMargin; x < picture.width + kMargin; ++x) *guides[g].at(x, y) /= kGuideScale[g];
    }
  }
  StatisticalTask task{.width = picture.width,
                       .height = picture.height,
                       .window_radius = kAveragingRadius,
                       .critical = 0,
                       .inside = view(picture.inside),
                       .guides = static_cast<int>(guides.size())};
  set_views(picture.first, task.first);
  set_views(picture.second, task.second);
  set_views(picture.usual, task.variance);
  set_views(picture.usual, task.usual);
  set_views(guides, task.guide);
  const Plane empty(picture.width, picture.height);
  std::array<Averages, std::size(kCriticalSquares)> averages;
  std::vector<Candidate> candidates;
  for (std::size_t i = 0; i < averages.size(); ++i) {
    task.critical = kCriticalSquares[i];
    averages[i].first.fill(empty), averages[i].second.fill(empty);
    for (std::size_t c = 0; c < 3; ++c) {
      task.first_out[c] = averages[i].first[c].at(0, 0);
      task.second_out[c] = averages[i].second[c].at(0, 0);
    }
    task.stride = empty.stride();
    parallel_for(static_cast<std::size_t>(picture.height), threads,
                 [&](std::size_t y) { kernel().statistical_row(task, static_cast<int>(y)); });
    candidates.push_back({averages[i].first, averages[i].second});
  }
  return mixed(picture, candidates, threads);
}

}  // namespace tessera::client::denoise
