// Result of a tile unit: per pixel, one node of the binary sum tree over its sample indices.
//
// The tree of a pixel with S samples has leaves 0..S-1. The node [k 2^m, (k+1) 2^m) is its left child where
// the right child lies beyond S, else merge(left, right). Whatever way a frame was cut into units, merging
// their nodes gives the same bits [docs/decisions/0003-result-layout.md]. `merge_pixel_nodes` is the one
// place of that arithmetic; it is compiled without fused multiply-add and used by workers and clients alike.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace tessera::wire {

/// Kind of values in a channel, and so how two nodes merge.
enum class ChannelKind : std::uint8_t {
  kSum = 0,  // sum over samples: a + b
  kSquaredDeviation =
      1,       // sum of squared deviations from the mean of the kSum channel `of` [Chan et al. 1979]
  kFirst = 2,  // value of the node's first sample: a number that has no mean
  // A list of identifiers, each with the weight of its samples: pairs of neighbouring channels, the first
  // pair (kEntry) what a sample has, the others (kFurtherEntry) empty there. `of` is the list's first
  // channel.
  kEntry = 3,
  kFurtherEntry = 4
};

/// Whether samples have a value of their own for such a channel.
constexpr bool is_sampled(ChannelKind kind) {
  return kind != ChannelKind::kSquaredDeviation && kind != ChannelKind::kFurtherEntry;
}

/// Identifiers of a list. Where a node has more, those of the least weight are left out.
inline constexpr std::size_t kListEntries = 8;

struct ChannelDesc {
  std::string name;  // "R", "G", "B", "A", "variance.R", "albedo.R", "normal.X", "depth.Z", "id.shape"
  ChannelKind kind = ChannelKind::kSum;
  // Index of the kSum channel that a kSquaredDeviation channel belongs to, or of a list's first channel.
  std::uint8_t of = 0;

  bool operator==(const ChannelDesc&) const = default;
};

/// Nodes of equal sample range for a rectangle of pixels.
struct TileResult {
  std::uint32_t x0 = 0, y0 = 0, x1 = 0, y1 = 0;  // pixels of the film
  std::uint32_t sample_begin = 0, sample_end = 0;
  std::vector<ChannelDesc> channels;
  std::vector<std::uint32_t> counts;  // samples taken, per pixel, rows from the top
  std::vector<float> values;          // channel-major: values[c * pixels + i]

  std::size_t pixel_count() const { return std::size_t{x1 - x0} * (y1 - y0); }
};

/// True when the ranges of `a` and `b` are the two children of one node of the tree over `spp` samples.
bool are_siblings(std::uint32_t a_begin, std::uint32_t a_end, std::uint32_t b_begin, std::uint32_t b_end,
                  std::uint32_t spp);

/// Merges `right` into `left`, channel by channel, for `pixels` pixels. Both hold channel-major planes with a
/// stride of `left_stride` and `right_stride` floats between channels. Counts are added.
void merge_pixel_nodes(const std::vector<ChannelDesc>& channels, std::size_t pixels,
                       std::uint32_t* left_counts, float* left, std::size_t left_stride,
                       const std::uint32_t* right_counts, const float* right, std::size_t right_stride);

enum class Packing {
  kZstd,  // compressed, with a checksum: for the network and disks
  kNone   // the words as they are: for results that stay in the memory of one process
};

std::string encode_tile_result(const TileResult& result, Packing packing = Packing::kZstd);

/// Adds to a list of kListEntries pairs, identifier and weight, `stride` floats apart. Weight 0 is a free
/// place.
void add_to_list(float* list, std::size_t stride, float identifier, float weight);

/// Most channels of a result.
inline constexpr std::size_t kMaxChannels = 640;

/// InvalidArgument, with what is wrong, for bytes that are not a result; nothing larger than `max_pixels`
/// pixels of `max_channels` channels is ever allocated, however much the bytes would inflate to.
absl::StatusOr<TileResult> decode_tile_result(std::string_view bytes,
                                              std::size_t max_pixels = std::size_t{1} << 24,
                                              std::size_t max_channels = kMaxChannels);

}  // namespace tessera::wire
