#include "render/film/noise_pilot.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <utility>

#include "base/split_mix.h"
#include "render/film/common_places.h"
#include "render/film/pixel_order.h"
#include "wire/limits.h"

namespace tessera::render {
namespace {

using wire::kNoiseBlock;

constexpr std::uint32_t kBlockPixels = kNoiseBlock * kNoiseBlock;
/// Streams of a pixel's pilot: sequences that are independent of each other, and of the picture's.
constexpr std::uint32_t kFirstStream = 0x6e6f6973;

/// Blocks of the part.
FilmRect blocks_of(const FilmRect& crop, const PartRequest& part) {
  const wire::PilotBlocks stripe = wire::pilot_stripe({.first_part = part.part,
                                                       .end_part = part.part + 1,
                                                       .parts = part.parts,
                                                       .crop = {crop.x0, crop.y0, crop.x1, crop.y1}});
  return {stripe.x0, stripe.y0, stripe.x1, stripe.y1};
}

/// One sample in some sixty is the pilot's, as far as the target tells how many there will be, and a quarter
/// of a sample a pixel at least: pixels of a block that are sampled.
/// Neighbours that share light do not judge each other: there are two groups at least.
std::uint32_t pilot_pixels(const NoiseTarget& target, PixelGroup group) {
  const double usual = 1 / (9 * target.noise * target.noise);
  const double samples = std::min<double>(target.samples, usual) / 64;
  const std::uint32_t least = std::max(4u, 2 * static_cast<std::uint32_t>(group.count()));
  return std::clamp(std::bit_ceil(static_cast<std::uint32_t>(samples * 16)), least, kBlockPixels);
}

/// Samples of a batch, which all cost the same as far as is known: fewer tell costs apart, more fill wide
/// registers.
constexpr std::size_t kMostTogether = 256;
/// Samples of each of the two streams of a pixel: as many as show what even distribution gains.
constexpr std::uint32_t kTogether = 2;

}  // namespace

NoisePilot::NoisePilot(const FilmRect& crop, FilmSize film, const PartRequest& part,
                       const NoiseTarget& target, bool scatters, PixelGroup group, std::uint64_t seed,
                       const RenderStats& stats)
    : blocks_(blocks_of(crop, part)),
      group_(group),
      sampled_pixels_per_block_(pilot_pixels(target, group)),
      scatters_(scatters),
      stats_(stats),
      opened_(blocks_.pixel_count()),
      rays_(stats.rays()) {
  // Those of a batch are neighbours, whose samples cost about the same.
  for (const std::uint32_t block : z_order(blocks_.width(), blocks_.y1 - blocks_.y0)) open_block(block, film);
  if (scatters_) make_places(seed);
}

/// The first groups in an order whose bits are reversed are evenly spread, and so are those that
/// follow: the halves of a block.
void NoisePilot::open_block(std::uint32_t block, FilmSize film) {
  const std::uint32_t x = blocks_.x0 + block % blocks_.width(), y = blocks_.y0 + block / blocks_.width();
  opened_[block].pixels_begin = pixels_.size();
  const auto turned = static_cast<std::uint32_t>(base::split_mix(std::uint64_t{y} << 32 | x));
  const std::vector<PixelPlace> places =
      groups_in(x * kNoiseBlock, y * kNoiseBlock, kNoiseBlock, kNoiseBlock, group_);
  const auto size = static_cast<std::uint32_t>(group_.count());
  const auto groups = static_cast<std::uint32_t>(places.size() / size);
  const int bits = std::countr_zero(groups);
  std::uint32_t number = 0;
  for (std::uint32_t i = 0; i < groups && number < sampled_pixels_per_block_; ++i) {
    std::uint32_t group = 0;
    for (int k = 0; k < bits; ++k) group |= ((i ^ turned) >> k & 1) << (bits - 1 - k);
    const std::size_t begin = pixels_.size();
    for (std::uint32_t k = 0; k < size; ++k) {
      const PixelPlace& place = places[group * size + k];
      const std::uint32_t px = x * kNoiseBlock + place.x, py = y * kNoiseBlock + place.y;
      pixels_.push_back({block, px, py, number + k, film.reaches(px, py, 0, 0), {}});
    }
    if (std::ranges::any_of(std::span(pixels_).subspan(begin), &Pixel::in_film)) {
      number += size;
    } else {
      pixels_.resize(begin);
    }
  }
  opened_[block].pixels_end = pixels_.size();
}

void NoisePilot::make_places(std::uint64_t seed) {
  for (std::uint32_t stream = 0; stream < 2; ++stream) {
    for (std::uint32_t number = 0; number < sampled_pixels_per_block_; ++number) {
      for (std::uint32_t i = 0; i < kTogether; ++i) {
        const Place place =
            shifted_place(base::split_mix(seed + kFirstStream + stream * kBlockPixels + number), i);
        x_.push_back(place.x), y_.push_back(place.y);
      }
    }
  }
  common_ = {0, x_.data(), y_.data()};
}

std::size_t NoisePilot::next(std::span<SampleName> names) {
  given_.clear();
  const std::size_t most = std::min(names.size(), kMostTogether);
  const auto group = static_cast<std::size_t>(group_.count());
  while (given_.size() + group <= most && pixel_ < pixels_.size()) {
    const std::uint32_t stream = sample_ / kTogether;
    for (std::size_t i = pixel_; i < pixel_ + group; ++i) {
      const Pixel& pixel = pixels_[i];
      names[given_.size()] = {
          pixel.x, pixel.y,
          (stream * sampled_pixels_per_block_ + pixel.number) * kTogether + sample_ % kTogether,
          pixel.in_film ? kFirstStream + stream : kUnsampled};
      given_.push_back(i);
    }
    if (++sample_ == 2 * kTogether) sample_ = 0, pixel_ += group;
  }
  return given_.size();
}

void NoisePilot::splat(std::span<const Splat>) { assert(!"only passes take light that lands anywhere"); }

void NoisePilot::add(std::span<const SampleName> names, const float* planes, std::size_t stride) {
  const std::uint64_t rays = stats_.rays();
  const auto is_sampled = [](const SampleName& name) { return name.stream != kUnsampled; };
  const double cost =
      static_cast<double>(rays - rays_) / static_cast<double>(std::ranges::count_if(names, is_sampled));
  rays_ = rays;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (!is_sampled(names[i])) continue;
    Pixel& pixel = pixels_[given_[i]];
    for (std::size_t c = 0; c < kColors; ++c)
      pixel.stream_sums[names[i].stream - kFirstStream][c] += static_cast<double>(planes[c * stride + i]);
    opened_[pixel.block].rays += cost;
    ++opened_[pixel.block].samples;
  }
}

NoisePilot::Color NoisePilot::mean_of(std::span<const Pixel> pixels) {
  const auto seen = static_cast<double>(std::ranges::count_if(pixels, &Pixel::in_film));
  Color mean{};
  for (const Pixel& pixel : pixels) {
    if (!pixel.in_film) continue;
    for (std::size_t c = 0; c < kColors; ++c)
      mean[c] += (pixel.stream_sums[0][c] + pixel.stream_sums[1][c]) / (2 * double{kTogether} * seen);
  }
  return mean;
}

NoisePilot::Errors NoisePilot::errors() const {
  Errors errors;
  double seen = 0;
  const auto size = static_cast<std::size_t>(group_.count());
  for (const Block& block : opened_) {
    const Color mean =
        mean_of(std::span(pixels_).subspan(block.pixels_begin, block.pixels_end - block.pixels_begin));
    const auto relative = [&](const Color& apart) {
      double sum = 0;
      for (std::size_t c = 0; c < kColors; ++c)
        sum += apart[c] * apart[c] / (2 * double{kTogether} * (mean[c] * mean[c] + wire::kPilotDarkness));
      return sum / kColors;
    };
    for (std::size_t first = block.pixels_begin; first < block.pixels_end; first += size) {
      Color of_group{};
      double members = 0;
      for (std::size_t i = first; i < first + size; ++i) {
        const Pixel& pixel = pixels_[i];
        if (!pixel.in_film) continue;
        ++members;
        Color apart;
        for (std::size_t c = 0; c < kColors; ++c) {
          apart[c] = pixel.stream_sums[0][c] - pixel.stream_sums[1][c];
          of_group[c] += apart[c];
        }
        errors.pixel += relative(apart);
      }
      errors.group += relative(of_group);
      seen += members;
    }
  }
  if (seen > 0) errors.pixel /= seen, errors.group /= seen;
  return errors;
}

/// The variance of a pixel's samples is that of the means of its two streams, which are independent: half the
/// square of what lies between them, times the samples of each. Means of several samples see what evenly
/// distributed ones gain.
Pilot NoisePilot::result() const {
  Pilot pilot{blocks_, std::vector<PilotBlock>(blocks_.pixel_count())};
  for (std::size_t block = 0; block < pilot.values.size(); ++block) {
    const Block& opened = opened_[block];
    const std::span pixels =
        std::span(pixels_).subspan(opened.pixels_begin, opened.pixels_end - opened.pixels_begin);
    const auto group = static_cast<std::size_t>(group_.count());
    const std::size_t halves[] = {0, (pixels.size() / group + 1) / 2 * group, pixels.size()};
    const double samples = kTogether;
    const Color mean = mean_of(pixels);
    PilotBlock& found = pilot.values[block];
    for (std::size_t half = 0; half < 2; ++half) {
      double error = 0, count = 0;
      for (std::size_t i = halves[half]; i < halves[half + 1]; ++i) {
        if (!pixels[i].in_film) continue;
        ++count;
        for (std::size_t c = 0; c < kColors; ++c) {
          const double apart = (pixels[i].stream_sums[0][c] - pixels[i].stream_sums[1][c]) / samples;
          error += apart * apart / 2 * samples / (mean[c] * mean[c] + wire::kPilotDarkness);
        }
      }
      // One pixel alone makes but one half.
      found.error[half] = count > 0
                              ? std::min(static_cast<float>(error / (kColors * count)), wire::kMostPilotError)
                              : found.error[0];
    }
    found.cost = std::clamp(static_cast<float>(opened.rays / opened.samples), 1.0f, wire::kMostPilotError);
  }
  return pilot;
}

namespace {

/// The same blocks, as they are sent; `pilot` has none then.
wire::PilotBlocks taken(Pilot& pilot) {
  const FilmRect& blocks = pilot.blocks;
  return {blocks.x0, blocks.y0, blocks.x1, blocks.y1, std::exchange(pilot.values, {})};
}

}  // namespace

std::string pilot_blob(Pilot pilot) { return wire::pilot_blob(taken(pilot)); }

bool append_pilot_blob(std::string_view blob, Pilot& pilot) {
  wire::PilotBlocks blocks = taken(pilot);
  const bool is_one = wire::append_pilot_blob(blob, blocks);
  pilot = {{blocks.x0, blocks.y0, blocks.x1, blocks.y1}, std::move(blocks.values)};
  return is_one;
}

}  // namespace tessera::render
