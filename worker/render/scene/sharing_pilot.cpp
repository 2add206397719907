#include "render/scene/sharing_pilot.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "render/film/noise_pilot.h"
#include "render/film/pixel_order.h"

namespace tessera::render {
namespace {

/// Number of blocks; two groups of pixels of each are sampled, 4 times.
constexpr std::uint32_t kBlocks = 48;
/// Number of the noisiest blocks that are left out: few bright samples make most of their noise.
constexpr std::size_t kWorst = 3;
/// CPU time of a ray to a neighbour, with the BSDFs at its ends, over that of a ray of paths, with all that
/// is done for it.
constexpr double kCostOfJoin = 1.0;
/// Gain below which pixels stay alone.
constexpr double kLeastGain = 1.05;

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
    const FilmSize film{static_cast<std::uint32_t>(scene.sensor.width),
                        static_cast<std::uint32_t>(scene.sensor.height)};
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

  std::vector<NoisePilot::Errors> errors() const {
    std::vector<NoisePilot::Errors> errors;
    for (const auto& pilot : pilots_) errors.push_back(pilot->errors());
    return errors;
  }

 private:
  const bool shared_;
  std::vector<std::unique_ptr<NoisePilot>> pilots_;
  std::size_t current_ = 0;
};

/// relMSE of pixels, and of means over blocks times their pixels, in one place of the film or several.
struct Noise {
  double pixels = 0, blocks = 0;

  Noise& operator+=(const Noise& more) {
    pixels += more.pixels, blocks += more.blocks;
    return *this;
  }
};
/// That of pixels alone, and of those that share.
struct Noises {
  Noise alone, shared;

  Noises& operator+=(const Noises& more) {
    alone += more.alone, shared += more.shared;
    return *this;
  }
  double quotient(double Noise::*part) const { return alone.*part > 0 ? shared.*part / alone.*part : 1; }
  /// The geometric mean of the quotients.
  double quotient() const { return std::sqrt(quotient(&Noise::pixels) * quotient(&Noise::blocks)); }
};

/// The sum over all places but for `without`.
Noises sum_of(const std::vector<Noises>& places, std::size_t without) {
  Noises sum;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (i != without) sum += places[i];
  }
  return sum;
}

/// The standard error of the logarithm of the sum's quotient(): the jackknife over places [Efron 1982].
double error_of_sum(const std::vector<Noises>& places) {
  const auto n = static_cast<double>(places.size());
  double sum = 0, squares = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const double x = std::log(std::max(sum_of(places, i).quotient(), 1e-9));
    sum += x, squares += x * x;
  }
  return std::sqrt(std::max((n - 1) * (squares / n - sum / n * (sum / n)), 0.0));
}

}  // namespace

double others_in_block(const PixelGroup& group) {
  constexpr int kBlock = SharingPilot::kBlock;
  const auto within = [](int apart, std::uint32_t side) {
    return std::max(0.0, 1 - std::abs(apart) / static_cast<double>(side));
  };
  double sum = 0;
  for (int y = 1 - kBlock; y < kBlock; ++y) {
    for (int x = 1 - kBlock; x < kBlock; ++x) {
      const bool same_place =
          x % static_cast<int>(group.width) == 0 && y % static_cast<int>(group.height) == 0;
      if (!same_place)
        sum += within(x, kBlock) * within(y, kBlock) * within(x, cell_width_of(group)) *
               within(y, cell_height_of(group));
    }
  }
  return sum / (group.step * group.step);
}

double SharingPilot::gain() const {
  return 1 / (std::sqrt(noise * noise_of_blocks) * (1 + kCostOfJoin * (rays - 1)));
}

bool SharingPilot::pays() const { return gain() >= kLeastGain && gain() * std::exp(-error) > 1; }

bool SharingPilot::beats(const SharingPilot& other) const {
  return gain() * std::exp(-2 * std::hypot(error, other.error)) > other.gain();
}

float SharingPilot::caution() const {
  if (!(alone * noise > 0)) return 1;
  const double quotient = (1 + alone) / (alone * noise);
  return static_cast<float>(std::clamp(kCautionScale * std::sqrt(quotient), 1.0, kMostCaution));
}

SharingPilot make_sharing_pilot(const Algorithm& algorithm, const SceneTables& scene, const RayQuery& rays,
                                const Prepared* prepared, bool scatters, PixelGroup group) {
  std::vector<NoisePilot::Errors> errors[2];
  double asked[2];
  for (const bool shared : {false, true}) {
    RenderStats stats;
    Blocks blocks(scene, scatters, group, shared, stats);
    algorithm.make({scene, rays, kSeed, stats, prepared})->render(blocks, blocks, {});
    errors[shared] = blocks.errors();
    asked[shared] = static_cast<double>(stats.rays());
  }
  if (asked[0] == 0) return {};
  // The mean of a group has the noise of independent pixels, and beyond that only what they have in common.
  const double others = others_in_block(group) / (group.count() - 1);
  std::vector<Noises> places;
  for (std::size_t i = 0; i < errors[0].size(); ++i) {
    const auto noise_of = [others](const NoisePilot::Errors& found) {
      return Noise{found.pixel, found.pixel + others * (found.group - found.pixel)};
    };
    places.push_back({noise_of(errors[0][i]), noise_of(errors[1][i])});
  }
  std::ranges::sort(places, {}, [](const Noises& place) { return place.alone.pixels + place.shared.pixels; });
  places.resize(places.size() - kWorst);
  const Noises all = sum_of(places, places.size());
  return {.noise = all.quotient(&Noise::pixels),
          .rays = asked[1] / asked[0],
          .noise_of_blocks = all.quotient(&Noise::blocks),
          .alone = all.alone.pixels / static_cast<double>(places.size()),
          .error = error_of_sum(places)};
}

}  // namespace tessera::render
