// A job's picture as it grows, for people who look on.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "wire/noise_pilot_blob.h"
#include "wire/tile_result.h"

namespace tessera::server {

/// Pixels [x0, x1) x [y0, y1) of the film.
struct PixelArea {
  std::uint32_t x0 = 0, y0 = 0, x1 = 0, y1 = 0;

  std::uint32_t width() const { return x1 - x0; }
  std::uint32_t height() const { return y1 - y0; }
  bool empty() const { return x0 >= x1 || y0 >= y1; }
  bool operator==(const PixelArea&) const = default;
};

PixelArea intersection(const PixelArea& a, const PixelArea& b);

/// One of the ways to look at a job's results.
struct PictureLayer {
  enum class Kind {
    kMean,     // the mean of up to three channels
    kFirst,    // a number that has no mean (ChannelKind::kFirst)
    kNoise,    // standard error of the pixel's luminance
    kSamples,  // samples taken
    kCost      // CPU seconds that a pixel's tile took, of its 1024 pixels
  };

  /// Origin of kNoise.
  enum class Noise {
    kSpread,    // distance of the means of a pixel's results
    kVariance,  // the results' own variance of samples
    kPilot      // what the job's pilot foresaw
  };

  std::string name;  // "color", "alpha", "albedo", "noise", ...
  Kind kind = Kind::kMean;
  // Channels of the results; kNoise: those of the colour, with kVariance then its squared deviations.
  std::vector<std::size_t> channels;
  Noise noise = Noise::kSpread;

  bool is_color() const { return kind == Kind::kMean && channels.size() == 3; }
};

/// The layers of results with these channels; the colour is first. `has_pilot`: the job's noise was measured
/// before its picture, which then has one result a pixel.
std::vector<PictureLayer> layers_of(const std::vector<wire::ChannelDesc>& channels, bool has_pilot);

/// Sums of all results so far. Frames of more than kMostPixels are kept reduced: at level n, one pixel is the
/// mean of 2^n x 2^n pixels of the film, weighted by their samples. Finer levels are made from the results
/// (add() of a picture of a part of the film). Not thread-safe.
class Picture {
 public:
  static constexpr std::size_t kMostPixels = std::size_t{1} << 22;
  static constexpr std::uint32_t kMostAreas = 4096;

  /// The level from which on the whole of `area` is kept.
  static std::uint32_t level_for(const PixelArea& area);

  /// Memory that a picture of the whole of `area` takes.
  static std::size_t bytes_for(const PixelArea& area, const PictureLayer& layer);

  /// An empty one of `area`, which begins at a multiple of 2^level pixels.
  Picture(PixelArea area, std::uint32_t level, PictureLayer layer);

  /// For Noise::kPilot: results that come without it leave no trace.
  void set_pilot(std::shared_ptr<const wire::PilotBlocks> pilot) { pilot_ = std::move(pilot); }

  /// Takes what lies within the area. `cpu_seconds`: what the result took, for kCost. InvalidArgument where
  /// the result lacks a channel.
  absl::Status add(const wire::TileResult& result, double cpu_seconds);

  /// Pixels of `level`, which is not below the picture's, that lie in `part` (in pixels of that level, within
  /// the area's), row by row, as floats in the machine's order: R, G, B and 1, or 0 without samples, for
  /// colours as 16-bit floats (IEEE 754 binary16); one 32-bit float, NaN without samples, for all else.
  std::string pixels(std::uint32_t level, const PixelArea& part) const;

  const PixelArea& area() const { return area_; }
  std::uint32_t level() const { return level_; }
  const PictureLayer& layer() const { return layer_; }

  /// Changes so far; and the areas of those after `since`, or nothing when these are not known any more.
  std::uint64_t changes() const { return changes_; }
  std::optional<std::vector<PixelArea>> changed_since(std::uint64_t since) const;

 private:
  /// The sums of one pixel of the picture.
  struct Cell {
    double weight = 0;  // samples
    double sum[3] = {0, 0, 0};
    double squares = 0;       // luminances of results' means, squared, weighted by their samples; or variance
    std::uint32_t parts = 0;  // results
  };
  void add_row(const wire::TileResult& result, std::uint32_t y, const PixelArea& common,
               double seconds_a_pixel);
  void add_noise(const wire::TileResult& result, std::uint32_t x, std::uint32_t y, std::size_t to);
  double noise_of(const Cell& cell) const;
  void merge(Cell& into, const Cell& cell) const;
  Cell cell_at(std::uint32_t level, std::uint32_t x, std::uint32_t y) const;
  void write(const Cell& cell, std::string& bytes) const;

  PixelArea area_;
  std::uint32_t level_;
  PictureLayer layer_;
  std::size_t bands_;             // planes of sums
  std::uint32_t width_, height_;  // size in pixels of level_
  std::shared_ptr<const wire::PilotBlocks> pilot_;
  // Planes of width_ * height_: weights, then sums of bands_ channels; for noise, squares and parts too.
  std::vector<float> weights_, sums_, squares_, parts_;
  std::uint64_t changes_ = 0;
  std::deque<PixelArea> changed_;
};

}  // namespace tessera::server
