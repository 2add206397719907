#include "render/film/adaptive_tile.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <utility>

namespace tessera::render {
namespace {

using wire::kNoiseBlock;

constexpr std::size_t kColors = 3;  // the first channels: R, G, B
/// Squared error that counts as none at all in the dark, as relMSE has it [Rousselle et al. 2011].
constexpr double kDarkness = 0.01;

}  // namespace

/// Identifiers, each once, with the weights of their samples.
using IdentifierList = std::vector<std::pair<float, double>>;

struct AdaptiveTile::Block {
  struct Pixel {
    std::uint32_t x, y;
  };
  /// Sums over one half's samples of one pixel.
  struct Sums {
    std::array<double, kColors> early{};    // over the first half of the pilot
    std::array<double, kColors> squares{};  // of the colours
    std::vector<double> values;             // of every plane
    std::vector<IdentifierList> lists;      // of every list
  };
  std::vector<Pixel> pixels;          // along a Z-order curve, so that 16 in a row are neighbours
  std::vector<std::uint32_t> all;     // their numbers
  std::vector<std::uint32_t> inside;  // those of the tile
  std::array<std::vector<Sums>, 2> halves;
  std::array<std::uint32_t, 2> counts{kPilotSamples, kPilotSamples};  // samples a pixel
  std::size_t missing = 0;                                            // samples on their way
  bool decided = false;
};

AdaptiveTile::AdaptiveTile(wire::TileResult& result, std::uint32_t film_width, std::uint32_t film_height,
                           const NoiseTarget& target)
    : result_(result),
      film_width_(film_width),
      film_height_(film_height),
      target_(target),
      next_x_(result.x0 / kNoiseBlock),
      next_y_(result.y0 / kNoiseBlock) {
  result_.counts.assign(result_.pixel_count(), 0);
  result_.values.assign(result_.channels.size() * result_.pixel_count(), 0.0f);
  for (const wire::ChannelDesc& channel : result_.channels) {
    const bool begins_list = channel.kind == wire::ChannelKind::kEntry && channel.of == plane_of_.size();
    if (channel.kind == wire::ChannelKind::kSum) summed_.push_back(planes_);
    if (channel.kind == wire::ChannelKind::kFirst) firsts_.push_back(planes_);
    if (begins_list) lists_.push_back(planes_);
    plane_of_.push_back(wire::is_sampled(channel.kind) ? planes_++ : plane_of_[channel.of]);
  }
}

AdaptiveTile::~AdaptiveTile() = default;

// ---------------------------------------------------------------- what is wanted

std::size_t AdaptiveTile::next(std::span<SampleName> names) {
  given_.clear();
  while (given_.size() < names.size()) {
    // Wishes of open blocks go first, so that few blocks are open.
    if (runs_.empty()) {
      if (next_y_ * kNoiseBlock >= result_.y1) break;
      open_block();
    }
    Run& run = runs_.front();
    const std::uint32_t number = run.pixels[run.at];
    const Block::Pixel& pixel = run.block->pixels[number];
    names[given_.size()] = {pixel.x, pixel.y, run.sample, run.half};
    given_.push_back({run.block, run.half, number, run.sample});
    if (++run.at < run.pixels.size()) continue;
    run.at = 0;
    if (++run.sample == run.end) runs_.pop_front();
  }
  return given_.size();
}

void AdaptiveTile::open_block() {
  const std::uint32_t x0 = next_x_ * kNoiseBlock, y0 = next_y_ * kNoiseBlock;
  if (++next_x_ * kNoiseBlock >= result_.x1) next_x_ = result_.x0 / kNoiseBlock, ++next_y_;

  Block& block = *blocks_.emplace_back(std::make_unique<Block>());
  for (std::uint32_t code = 0; code < kNoiseBlock * kNoiseBlock; ++code) {
    const std::uint32_t x = x0 + (code & 1) + (code >> 1 & 2) + (code >> 2 & 4);
    const std::uint32_t y = y0 + (code >> 1 & 1) + (code >> 2 & 2) + (code >> 3 & 4);
    if (x >= film_width_ || y >= film_height_) continue;
    const auto number = static_cast<std::uint32_t>(block.pixels.size());
    block.all.push_back(number);
    if (x >= result_.x0 && x < result_.x1 && y >= result_.y0 && y < result_.y1)
      block.inside.push_back(number);
    block.pixels.push_back({x, y});
  }
  for (std::uint32_t half : {0, 1}) {
    block.halves[half].resize(block.pixels.size(), {.values = std::vector<double>(planes_),
                                                    .lists = std::vector<IdentifierList>(lists_.size())});
    want(block, half, 0, kPilotSamples, block.all);
  }
}

void AdaptiveTile::want(Block& block, std::uint32_t half, std::uint32_t begin, std::uint32_t end,
                        std::span<const std::uint32_t> pixels) {
  if (begin == end) return;
  block.missing += pixels.size() * (end - begin);
  runs_.push_back({&block, half, begin, end, pixels});
}

// ---------------------------------------------------------------- what came

FilmRect AdaptiveTile::rect() const { return {result_.x0, result_.y0, result_.x1, result_.y1}; }

void AdaptiveTile::splat(std::span<const Splat>) { assert(!"only passes take light that lands anywhere"); }

void AdaptiveTile::add(std::span<const SampleName>, const float* planes, std::size_t stride) {
  for (std::size_t i = 0; i < given_.size(); ++i) {
    Block& block = *given_[i].block;
    take(given_[i], planes + i, stride);
    if (--block.missing > 0) continue;
    if (!block.decided) decide(block);
    if (block.missing == 0) finish(block);
  }
}

void AdaptiveTile::take(const Given& given, const float* sample, std::size_t stride) {
  Block::Sums& sums = given.block->halves[given.half][given.pixel];
  const auto add = [&](const std::vector<std::size_t>& planes) {
    for (const std::size_t c : planes) sums.values[c] += static_cast<double>(sample[c * stride]);
  };
  add(summed_);
  if (given.half == 0 && given.sample == 0) add(firsts_);
  for (std::size_t i = 0; i < lists_.size(); ++i) {
    const float* const entry = sample + lists_[i] * stride;
    auto& list = sums.lists[i];
    if (entry[stride] == 0) continue;
    const auto found = std::ranges::find(list, entry[0], &std::pair<float, double>::first);
    if (found == list.end()) {
      list.emplace_back(entry[0], entry[stride]);
    } else {
      found->second += static_cast<double>(entry[stride]);
    }
  }
  for (std::size_t c = 0; c < kColors; ++c) {
    const double value = sample[c * stride];
    sums.squares[c] += value * value;
    if (given.sample < kPilotSamples / 2) sums.early[c] += value;
  }
}

/// The squared relative error of a pixel's mean over the pilot of one half: how far both halves of the pilot
/// lie apart, averaged over block and colours. That is without bias for independent samples, (a - b)^2 / 4
/// having the variance of (a + b) / 2 as its mean, and sees what stratified ones gain.
double AdaptiveTile::pilot_error(const Block& block, std::uint32_t half) const {
  double error = 0;
  for (std::size_t c = 0; c < kColors; ++c) {
    double squares = 0, sum = 0;
    for (const Block::Sums& sums : block.halves[half]) {
      const double late = sums.values[c] - sums.early[c];
      squares += (late - sums.early[c]) * (late - sums.early[c]);
      sum += sums.values[c];
    }
    const auto pixels = static_cast<double>(block.pixels.size());
    const double mean = sum / (pixels * kPilotSamples);
    error += squares / (pixels * kPilotSamples * kPilotSamples) / (mean * mean + kDarkness);
  }
  return error / kColors;
}

void AdaptiveTile::decide(Block& block) {
  block.decided = true;
  // Crosswise: a half that decided on itself would be biased.
  const std::uint32_t counts[2] = {samples_for(target_, pilot_error(block, 1)),
                                   samples_for(target_, pilot_error(block, 0))};
  for (std::uint32_t half : {0, 1}) {
    block.counts[half] = counts[half];
    // The pixels of other tiles were of use for the decision only.
    want(block, half, kPilotSamples, counts[half], block.inside);
  }
}

void AdaptiveTile::finish(Block& block) {
  for (const std::uint32_t pixel : block.inside) put_pixel(block, pixel);
  std::erase_if(blocks_, [&](const std::unique_ptr<Block>& other) { return other.get() == &block; });
}

/// The mean of both halves' means, as the sum that gives it when it is divided by the number of all samples.
/// `variance` over that number is the variance of this mean, as it is where every sample weighs the same.
void AdaptiveTile::put_pixel(const Block& block, std::size_t pixel) {
  const Block::Pixel& place = block.pixels[pixel];
  const std::size_t to =
      std::size_t{place.y - result_.y0} * (result_.x1 - result_.x0) + (place.x - result_.x0);
  const Block::Sums &a = block.halves[0][pixel], &b = block.halves[1][pixel];
  const double na = block.counts[0], nb = block.counts[1], n = na + nb;
  result_.counts[to] = block.counts[0] + block.counts[1];
  put_lists(block, pixel, to);
  for (std::size_t c = 0; c < result_.channels.size(); ++c) {
    if (result_.channels[c].kind >= wire::ChannelKind::kEntry) continue;
    const std::size_t plane = plane_of_[c];
    const double mean_a = a.values[plane] / na, mean_b = b.values[plane] / nb;
    double value = n * 0.5 * (mean_a + mean_b);
    if (result_.channels[c].kind == wire::ChannelKind::kFirst) value = a.values[plane];
    if (result_.channels[c].kind == wire::ChannelKind::kSquaredDeviation) {
      const double within = std::max(0.0, a.squares[plane] - na * mean_a * mean_a) +
                            std::max(0.0, b.squares[plane] - nb * mean_b * mean_b);
      const double between = (mean_a - mean_b) * (mean_a - mean_b) * na * nb / n;
      value = (within + between) * n * n / (4 * na * nb);
    }
    result_.values[c * result_.pixel_count() + to] = static_cast<float>(value);
  }
}

/// The means of both halves' shares, as weights of all samples.
void AdaptiveTile::put_lists(const Block& block, std::size_t pixel, std::size_t to) {
  const double n = block.counts[0] + block.counts[1];
  std::size_t list = 0;
  for (std::size_t c = 0; c < result_.channels.size(); ++c) {
    if (result_.channels[c].kind != wire::ChannelKind::kEntry || result_.channels[c].of != c) continue;
    std::vector<std::pair<float, double>> all;
    for (const std::uint32_t half : {0, 1}) {
      for (const auto& [identifier, weight] : block.halves[half][pixel].lists[list]) {
        const auto found = std::ranges::find(all, identifier, &std::pair<float, double>::first);
        const double share = weight * n * 0.5 / block.counts[half];
        if (found == all.end()) {
          all.emplace_back(identifier, share);
        } else {
          found->second += share;
        }
      }
    }
    ++list;
    float* const place = result_.values.data() + c * result_.pixel_count() + to;
    for (const auto& [identifier, share] : all)
      wire::add_to_list(place, result_.pixel_count(), identifier, static_cast<float>(share));
  }
}

}  // namespace tessera::render
