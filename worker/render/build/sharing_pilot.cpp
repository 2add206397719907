#include "render/build/sharing_pilot.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <vector>

#include "render/film/noise_pilot.h"

namespace tessera::render {
namespace {

/// Number of blocks; 16 pixels of each are sampled, 4 times.
constexpr std::uint32_t kBlocks = 32;
/// Number of the noisiest blocks that are left out: few bright samples make most of their noise.
constexpr std::size_t kWorst = 2;
/// CPU time of a ray to a neighbour, with the BSDFs at its ends, over that of a ray of paths, with all that
/// is done for it.
constexpr double kCostOfJoin = 1.2;

/// Pilots of single blocks, one after the other.
class Blocks final : public SampleSource, public Film {
 public:
  Blocks(const SceneTables& scene, bool scatters, PixelGroup group, bool shared, const RenderStats& stats)
      : shared_(shared) {
    const auto width = static_cast<std::uint32_t>(scene.camera.width),
               height = static_cast<std::uint32_t>(scene.camera.height);
    // The least that a pilot takes.
    const NoiseTarget target{.noise = 1, .samples = 1};
    for (std::uint32_t i = 0; i < kBlocks; ++i) {
      // An additive recurrence on the plane [Roberts 2018].
      const auto at = [i](double step, std::uint32_t pixels) {
        const double place = std::fmod(0.5 + step * i, 1.0) * pixels;
        return std::min(static_cast<std::uint32_t>(place), pixels - 1);
      };
      const std::uint32_t x = at(0.7548776662466927, width), y = at(0.5698402909980532, height);
      pilots_.push_back(std::make_unique<NoisePilot>(FilmRect{x, y, x + 1, y + 1}, width, height,
                                                     PartRequest{}, target, scatters, group,
                                                     scene.sampler.seed, stats));
    }
  }

  std::size_t next(std::span<SampleName> names) override {
    for (;; ++current_) {
      const std::size_t count = pilots_[current_]->next(names);
      if (count > 0 || current_ + 1 == pilots_.size()) return count;
    }
  }
  const CommonPlaces* places() const override { return pilots_[current_]->places(); }
  PixelGroup group() const override { return shared_ ? pilots_.front()->group() : PixelGroup{}; }
  FilmRect rect() const override { return pilots_[current_]->rect(); }
  void add(std::span<const SampleName> names, const float* planes, std::size_t stride) override {
    pilots_[current_]->add(names, planes, stride);
  }
  void splat(std::span<const Splat> splats) override { pilots_[current_]->splat(splats); }

  std::vector<double> errors() const {
    std::vector<double> errors;
    for (const auto& pilot : pilots_) {
      const PilotBlock block = pilot->result().values.front();
      errors.push_back(double{block.error[0]} + double{block.error[1]});
    }
    return errors;
  }

 private:
  const bool shared_;
  std::vector<std::unique_ptr<NoisePilot>> pilots_;
  std::size_t current_ = 0;
};

}  // namespace

double SharingPilot::gain() const { return 1 / (noise * (1 + kCostOfJoin * (rays - 1))); }

SharingPilot make_sharing_pilot(const Algorithm& algorithm, const SceneTables& scene, const RayQuery& rays,
                                const Prepared* prepared, bool scatters, PixelGroup group) {
  double noise[2], asked[2];
  std::vector<std::size_t> counted;
  for (const bool shared : {false, true}) {
    RenderStats stats;
    Blocks blocks(scene, scatters, group, shared, stats);
    algorithm.make({scene, rays, scene.sampler.seed, stats, prepared})->render(blocks, blocks, {});
    const std::vector<double> errors = blocks.errors();
    if (counted.empty()) {
      counted.resize(errors.size());
      std::iota(counted.begin(), counted.end(), std::size_t{0});
      std::ranges::sort(counted, {}, [&](std::size_t i) { return errors[i]; });
      counted.resize(errors.size() - kWorst);
    }
    noise[shared] = 0;
    for (const std::size_t i : counted) noise[shared] += errors[i];
    asked[shared] = static_cast<double>(stats.rays());
  }
  if (noise[0] == 0 || asked[0] == 0) return {};
  return {noise[1] / noise[0], asked[1] / asked[0]};
}

}  // namespace tessera::render
