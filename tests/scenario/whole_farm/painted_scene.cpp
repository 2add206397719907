#include "scenario/whole_farm/painted_scene.h"

#include <functional>

#include "absl/strings/str_cat.h"
#include "wire/aov_channels.h"
#include "wire/digest.h"
#include "wire/tile_result.h"

namespace tessera::test {
namespace {

/// Digest of the blobs of the phases before.
struct Read final : render::Prepared {
  std::string digest;
};

std::string digest_of(std::span<const std::string_view> blobs) {
  wire::Sha256 sha;
  for (const std::string_view blob : blobs) sha.update(blob);
  return sha.finish_hex();
}

/// The input of units that read nothing.
std::string read_by(const render::Prepared* prepared) {
  return prepared == nullptr ? "" : static_cast<const Read*>(prepared)->digest;
}

std::uint64_t mixed(std::uint64_t a, std::uint64_t b) {
  a = (a ^ b) * 0x9e3779b97f4a7c15;
  return a ^ a >> 31;
}

std::uint64_t paint_of(const v1::JobSpec& spec, std::uint64_t rounding) {
  return mixed(spec.view().seed(), rounding);
}

/// Sums over samples are sums of whole numbers, so any cut of them has the same bits.
wire::TileResult paint_tile(std::uint64_t paint, const std::vector<wire::ChannelDesc>& channels,
                            const std::string& read, const render::TileRequest& tile) {
  wire::TileResult result{tile.x0,         tile.y0,  tile.x1, tile.y1, tile.sample_begin,
                          tile.sample_end, channels, {},      {}};
  result.counts.assign(result.pixel_count(), tile.sample_end - tile.sample_begin);
  const std::uint64_t picture = mixed(paint, read.empty() ? 0 : std::stoull(read.substr(0, 16), nullptr, 16));
  for (std::size_t channel = 0; channel < channels.size(); ++channel) {
    for (std::uint32_t y = tile.y0; y < tile.y1; ++y) {
      for (std::uint32_t x = tile.x0; x < tile.x1; ++x) {
        const std::uint64_t pixel = mixed(mixed(picture, channel), std::uint64_t{y} << 32 | x);
        std::uint64_t sum = 0;
        for (std::uint32_t sample = tile.sample_begin; sample < tile.sample_end; ++sample)
          sum += mixed(pixel, sample) & 255;
        result.values.push_back(static_cast<float>(sum));
      }
    }
  }
  return result;
}

/// Blobs of a phase are lists of their parts, so merging them in any order of pairs gives the same.
std::string part_of(std::uint64_t paint, std::uint32_t phase, std::uint32_t part, const std::string& read) {
  return absl::StrCat(paint, " ", phase, " ", part, " ", read, "\n");
}

/// Digest of the blobs that the phases make, as units of the picture read them.
std::string read_by_picture(const v1::JobSpec& spec, std::uint64_t paint) {
  std::vector<std::string> blobs;
  std::string read;
  for (int phase = 0; phase < spec.cut().phases_size(); ++phase) {
    std::string& blob = blobs.emplace_back();
    for (std::uint32_t part = 0; part < spec.cut().phases(phase).parts(); ++part)
      blob += part_of(paint, static_cast<std::uint32_t>(phase), part, read);
    const std::vector<std::string_view> views(blobs.begin(), blobs.end());
    read = digest_of(views);
  }
  return read;
}

}  // namespace

PaintedScene::PaintedScene(const v1::JobSpec& spec, std::uint64_t rounding, Events events)
    : paint_(paint_of(spec, rounding)),
      channels_(wire::channels_of(spec.view())),
      events_(std::move(events)) {}

absl::StatusOr<wire::TileResult> PaintedScene::render_tile(const render::TileRequest& tile,
                                                           std::stop_token stop,
                                                           render::RenderStats& stats) const {
  if (absl::Status status = events_.work(std::move(stop)); !status.ok()) return status;
  wire::TileResult result = paint_tile(paint_, channels_, read_by(tile.prepared), tile);
  stats.samples += result.pixel_count() * (tile.sample_end - tile.sample_begin);
  return result;
}

absl::StatusOr<std::shared_ptr<const render::Prepared>> PaintedScene::prepare(
    std::span<const std::string_view> blobs) const {
  if (absl::Status status = events_.read(); !status.ok()) return status;
  auto read = std::make_shared<Read>();
  read->digest = digest_of(blobs);
  return read;
}

absl::StatusOr<std::string> PaintedScene::make_part(const render::PartRequest& part, const render::FilmRect&,
                                                    std::stop_token stop, render::RenderStats&) const {
  if (absl::Status status = events_.work(std::move(stop)); !status.ok()) return status;
  return part_of(paint_, part.phase, part.part, read_by(part.prepared));
}

absl::StatusOr<std::string> PaintedScene::merge(std::uint32_t,
                                                std::span<const std::string_view> blobs) const {
  std::string merged;
  for (const std::string_view blob : blobs) merged += blob;
  return merged;
}

std::string right_payload(const v1::JobSpec& spec, std::uint64_t rounding, const v1::WorkUnit& unit) {
  const v1::PixelRect& pixels = unit.tile().pixels();
  const v1::SampleRange& samples = unit.tile().samples();
  const std::uint64_t paint = paint_of(spec, rounding);
  return wire::encode_tile_result(paint_tile(paint, wire::channels_of(spec.view()),
                                             read_by_picture(spec, paint),
                                             {.x0 = pixels.x0(),
                                              .y0 = pixels.y0(),
                                              .x1 = pixels.x1(),
                                              .y1 = pixels.y1(),
                                              .sample_begin = samples.begin(),
                                              .sample_end = samples.end()}));
}

}  // namespace tessera::test
