#include "render/build/sharing_pilot.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numeric>
#include <vector>

#include "render/film/noise_pilot.h"

namespace tessera::render {
namespace {

/// Number of blocks; two groups of pixels of each are sampled, 4 times.
constexpr std::uint32_t kBlocks = 48;
/// Number of the noisiest blocks that are left out: few bright samples make most of their noise.
constexpr std::size_t kWorst = 3;
/// CPU time of a ray to a neighbour, with the BSDFs at its ends, over that of a ray of paths, with all that
/// is done for it.
constexpr double kCostOfJoin = 1.0;
/// Gain below which pixels stay alone: whole groups at borders of tiles take a tenth more samples.
constexpr double kLeastGain = 1.1;

/// Factor of the root in caution(), which stands for the costs that it leaves out, and the most that is
/// taken: both by error x time on scenes [docs/decisions/0062-path-sharing.md].
constexpr double kCautionScale = 0.5;
constexpr double kMostCaution = 3;

/// The pilot's own seed: pictures with other seeds have the same verdict, which none of their samples sway.
constexpr std::uint64_t kSeed = 0x7368617265;

/// Pilots of single blocks, one after the other.
class Blocks final : public SampleSource, public Film {
 public:
  Blocks(const SceneTables& scene, bool scatters, PixelGroup group, bool shared, const RenderStats& stats)
      : shared_(shared) {
    const FilmSize film{static_cast<std::uint32_t>(scene.camera.width),
                        static_cast<std::uint32_t>(scene.camera.height)};
    // The least that a pilot takes.
    const NoiseTarget target{.noise = 1, .samples = 1};
    for (std::uint32_t i = 0; i < kBlocks; ++i) {
      // An additive recurrence on the plane [Roberts 2018].
      const auto at = [i](double step, std::uint32_t pixels) {
        const double place = std::fmod(0.5 + step * i, 1.0) * pixels;
        return std::min(static_cast<std::uint32_t>(place), pixels - 1);
      };
      const std::uint32_t x = at(0.7548776662466927, film.width), y = at(0.5698402909980532, film.height);
      pilots_.push_back(std::make_unique<NoisePilot>(FilmRect{x, y, x + 1, y + 1}, film, PartRequest{},
                                                     target, scatters, group, kSeed, stats));
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

/// The quotient of the sums of `b` and `a` over the blocks `counted`, all but `without`.
double quotient(const std::vector<double>& a, const std::vector<double>& b,
                const std::vector<std::size_t>& counted, std::size_t without) {
  double sum_a = 0, sum_b = 0;
  for (const std::size_t i : counted) {
    if (i != without) sum_a += a[i], sum_b += b[i];
  }
  return sum_a > 0 ? sum_b / sum_a : 1;
}

/// The standard error of the logarithm of that quotient: the jackknife over blocks [Efron 1982].
double error_of_quotient(const std::vector<double>& a, const std::vector<double>& b,
                         const std::vector<std::size_t>& counted) {
  const auto n = static_cast<double>(counted.size());
  double sum = 0, squares = 0;
  for (const std::size_t i : counted) {
    const double x = std::log(std::max(quotient(a, b, counted, i), 1e-9));
    sum += x, squares += x * x;
  }
  return std::sqrt(std::max((n - 1) * (squares / n - sum / n * (sum / n)), 0.0));
}

}  // namespace

double SharingPilot::gain() const { return 1 / (noise * (1 + kCostOfJoin * (rays - 1))); }

bool SharingPilot::pays() const { return gain() >= kLeastGain && gain() * std::exp(-error) > 1; }

float SharingPilot::caution() const {
  if (!(alone * noise > 0)) return 1;
  const double quotient = (1 + alone) / (alone * noise);
  return static_cast<float>(std::clamp(kCautionScale * std::sqrt(quotient), 1.0, kMostCaution));
}

SharingPilot make_sharing_pilot(const Algorithm& algorithm, const SceneTables& scene, const RayQuery& rays,
                                const Prepared* prepared, bool scatters, PixelGroup group) {
  std::vector<double> errors[2];
  double asked[2];
  for (const bool shared : {false, true}) {
    RenderStats stats;
    Blocks blocks(scene, scatters, group, shared, stats);
    algorithm.make({scene, rays, kSeed, stats, prepared})->render(blocks, blocks, {});
    errors[shared] = blocks.errors();
    asked[shared] = static_cast<double>(stats.rays());
  }
  std::vector<std::size_t> counted(errors[0].size());
  std::iota(counted.begin(), counted.end(), std::size_t{0});
  std::ranges::sort(counted, {}, [&](std::size_t i) { return errors[0][i] + errors[1][i]; });
  counted.resize(counted.size() - kWorst);
  if (asked[0] == 0) return {};
  double alone = 0;
  for (const std::size_t i : counted) alone += errors[0][i];
  return {.noise = quotient(errors[0], errors[1], counted, errors[0].size()),
          .rays = asked[1] / asked[0],
          .alone = alone / static_cast<double>(2 * counted.size()),  // the two halves of blocks
          .error = error_of_quotient(errors[0], errors[1], counted)};
}

}  // namespace tessera::render
