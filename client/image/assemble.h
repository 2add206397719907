// From tile results to an image.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "image/cryptomatte.h"
#include "image/image.h"
#include "image/node_store.h"
#include "image/tile_file.h"
#include "wire/tile_result.h"

namespace tessera::client {

struct AssemblyOptions {
  std::uint32_t width = 0, height = 0;  // size of the film
  Window crop;                          // the part of it that is rendered
  std::uint32_t spp = 0;
  std::vector<wire::ChannelDesc> channels;  // wire::channels_for_aovs
  // Lists among the channels that become Cryptomattes; others stay as they are.
  std::vector<MatteList> mattes;
  bool samples_channel = true;  // "samples": how many samples each pixel got
  // Pixels of the film on each side that are none of the display window, whose corner is (0, 0) of the image.
  std::uint32_t overscan = 0;
  // Results that wait for their sibling go to a temporary file when they need more bytes than this. 0: four
  // frames, and with the frame no more than max_frame_bytes.
  std::size_t max_pending_bytes = 0;
  // A frame of more bytes than this goes to a temporary file, tile by tile, where its tiles are squares of
  // `tile_size` on a grid from (0, 0); 0: they may be any rectangles, and the frame is kept in memory.
  std::size_t max_frame_bytes = SIZE_MAX;
  std::uint32_t tile_size = 0;
};

/// Pixels of one tile of which samples are missing.
struct Hole {
  Window pixels;
  bool empty = false;  // no sample at all: the marker pattern is in their place
};

struct Assembly {
  Image image;                 // its planes are empty where they are in `rows`
  std::unique_ptr<Rows> rows;  // null: the image has its pixels
  std::uint64_t incomplete_pixels = 0;
  std::vector<Hole> holes;  // tiles that are not whole, then rectangles that no tile covers
};

/// Puts the results of one job together. Results may come in any order; the image has the same bits whatever
/// the order. A pixel's value is the sum over its samples divided by their number; a `variance` channel is
/// the per-sample variance M2 / (n - 1), 0 for one sample. Memory: the frame, and `max_pending_bytes` of
/// waiting results; of a frame that goes to a file, a row of tiles.
class Assembler {
 public:
  /// InvalidArgument when the options do not fit one another.
  static absl::StatusOr<Assembler> create(AssemblyOptions options);

  /// Takes one result. AlreadyExists when some of that tile's samples are there already; InvalidArgument when
  /// the result is not of this job: other channels, outside the crop, a range that is no node of the sum
  /// tree, a tile that cuts another; Internal when the temporary file fails, after which the assembler is of
  /// no more use. Nothing changes on the other errors.
  absl::Status add(wire::TileResult result);

  /// Pixels times samples a pixel.
  std::uint64_t samples_total() const;
  std::uint64_t samples_done() const { return samples_done_; }
  bool complete() const { return samples_done_ == samples_total(); }

  /// The image. A pixel that lacks samples is the mean of those it has; `samples` tells how many that was.
  /// One that has none is marked (hole_marker.h), and 0 in all other channels. Every value is finite.
  absl::StatusOr<Assembly> finish() &&;

 private:
  // A node of a tile's sum tree; the key of its map is where the sample range begins.
  struct Node {
    std::uint32_t end = 0;
    NodeStore::Entry entry;
  };
  struct Tile {
    Window pixels;
    bool whole = false;  // the root went to the frame
    std::map<std::uint32_t, Node> nodes;
  };

  explicit Assembler(AssemblyOptions options);
  absl::Status make_frame();
  absl::Status check_result(const wire::TileResult& result) const;
  absl::StatusOr<Tile*> find_tile(const wire::TileResult& result);
  absl::StatusOr<Tile*> find_file_tile(const Window& pixels, const wire::TileResult& result);
  absl::StatusOr<wire::TileResult> merge_siblings(Tile& tile, wire::TileResult result);
  /// Planes of the frame from sums: those of pixels [begin, begin + count), `count` values of each plane, one
  /// plane behind the other.
  void to_planes(const wire::TileResult& sums, std::size_t begin, std::size_t count, std::span<float> planes);
  absl::Status put_in_frame(const Tile& tile, const wire::TileResult& sums);
  /// Marks the pixels that no tile has, and appends them to `holes`.
  void mark_missing(std::vector<Hole>& holes);
  /// The same of a frame in a file, where they stay black.
  void list_missing(std::vector<Hole>& holes) const;

  /// A Cryptomatte among the planes, and the channels of results of which it is made.
  struct Matte {
    MatteResolver resolver;
    std::size_t first_channel, channels, first_plane, planes;
  };

  AssemblyOptions options_;
  std::vector<std::size_t> plain_;  // channels of results that are planes, in order; then come Cryptomattes
  std::vector<Matte> mattes_;
  Image frame_;
  std::unique_ptr<TileFile> file_;  // holds the frame's pixels; null: they are in memory
  // Per pixel of the crop, or per tile of the file: 1 + index into tiles_, 0 for none yet.
  std::vector<std::uint32_t> owner_;
  std::vector<Tile> tiles_;
  NodeStore store_;
  std::uint64_t samples_done_ = 0;
};

}  // namespace tessera::client
