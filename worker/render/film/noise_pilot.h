// A pilot: few samples of each block of pixels, which tell how noisy samples are there and what they cost.
// They are none of the picture's and come from sequences of their own, so whatever is made of them, the
// picture's samples do not depend on it.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "render/film/film.h"
#include "render/film/noise_target.h"
#include "render/film/tile_request.h"
#include "wire/noise_pilot_blob.h"

namespace tessera::render {

using wire::PilotBlock;

struct Pilot {
  FilmRect blocks;  // counted in blocks of wire::kNoiseBlock pixels each way, on the film's grid
  std::vector<PilotBlock> values;  // rows from the top
};

class NoisePilot final : public SampleSource, public Film {
 public:
  /// Samples the blocks of one part of the film's `crop`. `stats` are those of the integrator: costs are read
  /// from them. `scatters`: samples lie anywhere in their pixels, and not as the filter is distributed.
  /// `group`: neighbours that share light.
  NoisePilot(const FilmRect& crop, FilmSize film, const PartRequest& part, const NoiseTarget& target,
             bool scatters, PixelGroup group, std::uint64_t seed, const RenderStats& stats);

  std::size_t next(std::span<SampleName> names) override;
  const CommonPlaces* places() const override { return scatters_ ? &common_ : nullptr; }
  PixelGroup group() const override { return group_; }
  FilmRect rect() const override { return blocks_; }
  void add(std::span<const SampleName> names, const float* planes, std::size_t stride) override;
  void splat(std::span<const Splat> splats) override;

  /// Returns what was found, when all samples have come.
  Pilot result() const;
  /// relMSE of a pixel's samples, and that of a group's means times its pixels: the same where these are
  /// independent.
  struct Errors {
    double pixel = 0, group = 0;
  };
  Errors errors() const;

 private:
  static constexpr std::size_t kColors = 3;  // the first channels: R, G, B
  struct Pixel {
    std::uint32_t block, x, y, number;  // `number` within the block
    bool in_film;                       // false: a neighbour of a pixel that is
    std::array<std::array<double, kColors>, 2> stream_sums{};
  };

  struct Block {
    std::size_t pixels_begin = 0, pixels_end = 0;
    double rays = 0;
    std::uint32_t samples = 0;
  };

  using Color = std::array<double, kColors>;
  void open_block(std::uint32_t block, FilmSize film);
  /// The mean over those of the pixels that are of the film.
  static Color mean_of(std::span<const Pixel> pixels);
  void make_places(std::uint64_t seed);

  const FilmRect blocks_;
  const PixelGroup group_;
  const std::uint32_t sampled_pixels_per_block_;
  const bool scatters_;
  const RenderStats& stats_;
  std::vector<Pixel> pixels_;
  std::vector<Block> opened_;  // rows from the top
  std::uint64_t rays_;         // stats_.rays() at the latest add()
  // Next sample
  std::size_t pixel_ = 0;
  std::uint32_t sample_ = 0;
  std::vector<std::size_t> given_;  // pixels of the samples of the latest next()
  std::vector<float> x_, y_;
  CommonPlaces common_{};
};

/// A pilot as bytes; empty for one without blocks.
std::string pilot_blob(Pilot pilot);
/// Puts `blob` under `pilot`, which may be empty. False where it is no blob of a pilot, or not of the blocks
/// that come next.
bool append_pilot_blob(std::string_view blob, Pilot& pilot);

}  // namespace tessera::render
