#include "image/assemble.h"

#include <algorithm>
#include <bit>
#include <iterator>
#include <utility>

#include "absl/strings/str_cat.h"
#include "image/hole_marker.h"

namespace tessera::client {
namespace {

constexpr std::uint64_t kMaxPixelsInMemory = std::uint64_t{1} << 28;
constexpr std::uint64_t kMaxPixelsInFile = std::uint64_t{1} << 32;  // a film of the largest size

std::string describe(const wire::TileResult& r) {
  return absl::StrCat("result for pixels [", r.x0, ", ", r.x1, ") x [", r.y0, ", ", r.y1, "), samples [",
                      r.sample_begin, ", ", r.sample_end, ")");
}

absl::Status foreign(const wire::TileResult& result, const std::string& why) {
  return absl::InvalidArgumentError(absl::StrCat(describe(result), ": ", why));
}

// [k 2^m, (k + 1) 2^m), cut at spp: a node of the sum tree [proto/wire/tile_result.h].
bool is_tree_node(std::uint32_t begin, std::uint32_t end, std::uint32_t spp) {
  if (begin >= end || end > spp) return false;
  const std::uint64_t size = std::bit_ceil(std::uint64_t{end} - begin);
  return begin % size == 0 && (begin + size == end || end == spp);
}

void merge_into(wire::TileResult& left, const wire::TileResult& right) {
  const std::size_t pixels = left.pixel_count();
  wire::merge_pixel_nodes(left.channels, pixels, left.counts.data(), left.values.data(), pixels,
                          right.counts.data(), right.values.data(), pixels);
  left.sample_end = right.sample_end;
}

Window moved(const Window& window, std::int32_t by) {
  return {window.x0 + by, window.y0 + by, window.x1 + by, window.y1 + by};
}

/// The samples of channel `c`.
float pixel_value(const wire::ChannelDesc& channel, std::size_t c, float node, std::uint32_t count) {
  const wire::ChannelKind kind = channel.kind;
  const bool in_list = kind == wire::ChannelKind::kEntry || kind == wire::ChannelKind::kFurtherEntry;
  const bool identifies = in_list && (c - channel.of) % 2 == 0;
  if (kind == wire::ChannelKind::kFirst || identifies) return node;
  if (in_list) return count == 0 ? 0.0f : static_cast<float>(double{node} / count);
  const std::uint32_t divisor = kind == wire::ChannelKind::kSum ? count : std::max(count, 1u) - 1;
  return divisor == 0 ? 0.0f : static_cast<float>(double{node} / divisor);
}

}  // namespace

absl::StatusOr<Assembler> Assembler::create(AssemblyOptions options) {
  const auto fail = [](const std::string& what) {
    return absl::InvalidArgumentError(absl::StrCat("assembly: ", what));
  };
  const Window& crop = options.crop;
  if (options.width > kMaxPixelsInMemory || options.height > kMaxPixelsInMemory)
    return fail("the film is too large");
  if (crop.x0 < 0 || crop.y0 < 0 || crop.x1 <= crop.x0 || crop.y1 <= crop.y0 ||
      std::uint32_t(crop.x1) > options.width || std::uint32_t(crop.y1) > options.height) {
    return fail("the crop is empty or not inside the film");
  }
  if (options.spp == 0 || options.channels.empty()) return fail("no samples or no channels");
  if (2 * std::uint64_t{options.overscan} >= std::min(options.width, options.height))
    return fail("nothing of the film is within the overscan");
  Assembler assembler(std::move(options));
  if (absl::Status status = assembler.make_frame(); !status.ok()) return status;
  return assembler;
}

/// Names the planes of the frame: channels as they are, Cryptomattes, and the number of samples.
Assembler::Assembler(AssemblyOptions options) : options_(std::move(options)), store_(0) {
  frame_.data = options_.crop;
  frame_.display = {0, 0, std::int32_t(options_.width), std::int32_t(options_.height)};
  const std::vector<wire::ChannelDesc>& channels = options_.channels;
  std::vector<bool> in_matte(channels.size(), false);
  for (const MatteList& list : options_.mattes) {
    const auto is_of_list = [&](const wire::ChannelDesc& channel) {
      return channel.name.starts_with(absl::StrCat(list.list, "."));
    };
    const auto first = std::ranges::find_if(channels, is_of_list);
    const auto end = std::find_if_not(first, channels.end(), is_of_list);
    if (end - first < 2) continue;
    const auto first_channel = static_cast<std::size_t>(first - channels.begin());
    const auto count = static_cast<std::size_t>(end - first);
    mattes_.push_back({MatteResolver(list), first_channel, count, 0, 0});
    std::fill_n(in_matte.begin() + (first - channels.begin()), count, true);
  }
  for (std::size_t c = 0; c < channels.size(); ++c) {
    if (in_matte[c]) continue;
    plain_.push_back(c);
    frame_.channels.push_back({channels[c].name, {}});
  }
  for (Matte& matte : mattes_) {
    matte.first_plane = frame_.channels.size();
    for (std::string& name : matte.resolver.planes()) frame_.channels.push_back({std::move(name), {}});
    matte.planes = frame_.channels.size() - matte.first_plane;
  }
  frame_.channels.push_back({"samples", {}});
}

/// Makes room for the pixels: in memory, or in a file.
absl::Status Assembler::make_frame() {
  const Window& crop = options_.crop;
  const std::uint64_t pixels = std::uint64_t(crop.width()) * std::uint64_t(crop.height());
  const std::uint64_t bytes = pixels * frame_.channels.size() * sizeof(float);
  const std::size_t most = options_.max_frame_bytes;
  const bool in_file = options_.tile_size > 0 && bytes > most;
  if (pixels > (in_file ? kMaxPixelsInFile : kMaxPixelsInMemory))
    return absl::InvalidArgumentError("assembly: the crop is too large");
  if (in_file) {
    std::vector<std::size_t> marked;
    for (std::size_t plane = 0; plane < frame_.channels.size(); ++plane) {
      if (marks_holes(frame_.channels[plane].name)) marked.push_back(plane);
    }
    auto created = TileFile::create(crop, static_cast<std::int32_t>(options_.tile_size),
                                    frame_.channels.size(), std::move(marked));
    if (!created.ok()) return created.status();
    file_ = *std::move(created);
  } else {
    for (Channel& channel : frame_.channels) channel.values.resize(pixels);
  }
  owner_.resize(file_ ? file_->tiles() : pixels);
  const std::size_t left = file_ ? most : most - std::min<std::size_t>(most, bytes);
  store_ = NodeStore(options_.max_pending_bytes ? options_.max_pending_bytes
                                                : std::min<std::size_t>(4 * bytes, left));
  return absl::OkStatus();
}

std::uint64_t Assembler::samples_total() const { return std::uint64_t{frame_.pixel_count()} * options_.spp; }

absl::Status Assembler::check_result(const wire::TileResult& result) const {
  const Window& crop = options_.crop;
  if (result.x0 >= result.x1 || result.y0 >= result.y1 || result.x0 < std::uint32_t(crop.x0) ||
      result.y0 < std::uint32_t(crop.y0) || result.x1 > std::uint32_t(crop.x1) ||
      result.y1 > std::uint32_t(crop.y1)) {
    return foreign(result, "not inside the part of the film that is rendered");
  }
  if (!is_tree_node(result.sample_begin, result.sample_end, options_.spp)) {
    return foreign(result, absl::StrCat("not a node of the sum tree over ", options_.spp, " samples"));
  }
  if (result.channels != options_.channels) return foreign(result, "has other channels than the job");
  if (result.counts.size() != result.pixel_count() ||
      result.values.size() != result.pixel_count() * result.channels.size()) {
    return foreign(result, "its arrays do not have the tile's size");
  }
  const std::uint32_t samples = result.sample_end - result.sample_begin;
  if (std::ranges::any_of(result.counts, [&](std::uint32_t count) { return count > samples; })) {
    return foreign(result, "a pixel has more samples than the range");
  }
  return absl::OkStatus();
}

// The tile with exactly these pixels; a new one where no tile has any of them.
absl::StatusOr<Assembler::Tile*> Assembler::find_tile(const wire::TileResult& result) {
  const Window pixels{std::int32_t(result.x0), std::int32_t(result.y0), std::int32_t(result.x1),
                      std::int32_t(result.y1)};
  if (file_) return find_file_tile(pixels, result);
  const auto row_of = [&](std::int32_t y) {
    return owner_.begin() + std::ptrdiff_t(y - options_.crop.y0) * options_.crop.width() +
           (pixels.x0 - options_.crop.x0);
  };
  if (const std::uint32_t owner = *row_of(pixels.y0); owner != 0 && tiles_[owner - 1].pixels == pixels) {
    return &tiles_[owner - 1];
  }
  for (std::int32_t y = pixels.y0; y < pixels.y1; ++y) {
    if (std::any_of(row_of(y), row_of(y) + pixels.width(), [](std::uint32_t owner) { return owner != 0; })) {
      return foreign(result, "its pixels overlap those of another tile");
    }
  }
  Tile& tile = tiles_.emplace_back();
  tile.pixels = pixels;
  const auto owner = static_cast<std::uint32_t>(tiles_.size());
  for (std::int32_t y = pixels.y0; y < pixels.y1; ++y) std::fill_n(row_of(y), pixels.width(), owner);
  return &tile;
}

absl::StatusOr<Assembler::Tile*> Assembler::find_file_tile(const Window& pixels,
                                                           const wire::TileResult& result) {
  if (!file_->is_tile(pixels)) return foreign(result, "it is no tile of the job's grid");
  std::uint32_t& owner = owner_[file_->index_of(pixels.x0, pixels.y0)];
  if (owner == 0) {
    tiles_.emplace_back().pixels = pixels;
    owner = static_cast<std::uint32_t>(tiles_.size());
  }
  return &tiles_[owner - 1];
}

// Merges `result` with the waiting siblings, theirs with the next, as far up the tree as it goes.
absl::StatusOr<wire::TileResult> Assembler::merge_siblings(Tile& tile, wire::TileResult result) {
  while (true) {
    const auto right = tile.nodes.find(result.sample_end);
    const auto after = tile.nodes.lower_bound(result.sample_begin);
    if (right != tile.nodes.end() && wire::are_siblings(result.sample_begin, result.sample_end, right->first,
                                                        right->second.end, options_.spp)) {
      absl::StatusOr<wire::TileResult> sibling = store_.take(std::move(right->second.entry));
      if (!sibling.ok()) return sibling.status();
      tile.nodes.erase(right);
      merge_into(result, *sibling);
    } else if (after != tile.nodes.begin() && std::prev(after)->second.end == result.sample_begin &&
               wire::are_siblings(std::prev(after)->first, result.sample_begin, result.sample_begin,
                                  result.sample_end, options_.spp)) {
      const auto left = std::prev(after);
      absl::StatusOr<wire::TileResult> sibling = store_.take(std::move(left->second.entry));
      if (!sibling.ok()) return sibling.status();
      tile.nodes.erase(left);
      merge_into(*sibling, result);
      result = *std::move(sibling);
    } else {
      return result;
    }
  }
}

absl::Status Assembler::add(wire::TileResult result) {
  if (absl::Status status = check_result(result); !status.ok()) return status;
  const absl::StatusOr<Tile*> found = find_tile(result);
  if (!found.ok()) return found.status();
  Tile& tile = **found;

  // Refuse samples that are there already: those of the node that begins before the range's end.
  const auto next = tile.nodes.lower_bound(result.sample_end);
  if (tile.whole || (next != tile.nodes.begin() && std::prev(next)->second.end > result.sample_begin)) {
    return absl::AlreadyExistsError(absl::StrCat(describe(result), ": there already"));
  }

  samples_done_ += std::uint64_t{result.pixel_count()} * (result.sample_end - result.sample_begin);
  absl::StatusOr<wire::TileResult> merged = merge_siblings(tile, std::move(result));
  if (!merged.ok()) return merged.status();
  if (merged->sample_begin == 0 && merged->sample_end == options_.spp) {
    tile.whole = true;
    return put_in_frame(tile, *merged);
  }
  const std::uint32_t begin = merged->sample_begin, end = merged->sample_end;
  absl::StatusOr<NodeStore::Entry> entry = store_.put(*std::move(merged));
  if (!entry.ok()) return entry.status();
  tile.nodes.emplace(begin, Node{end, *std::move(entry)});
  return absl::OkStatus();
}

void Assembler::to_planes(const wire::TileResult& sums, std::size_t begin, std::size_t count,
                          std::span<float> planes) {
  const std::size_t pixels = sums.pixel_count();
  const auto value = [&](std::size_t c, std::size_t i) {
    return pixel_value(options_.channels[c], c, sums.values[c * pixels + begin + i], sums.counts[begin + i]);
  };
  for (std::size_t plane = 0; plane < plain_.size(); ++plane) {
    for (std::size_t i = 0; i < count; ++i) planes[plane * count + i] = value(plain_[plane], i);
  }
  std::vector<float> entries, ranks;
  for (Matte& matte : mattes_) {
    entries.resize(matte.channels);
    ranks.resize(matte.planes);
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t c = 0; c < matte.channels; ++c) entries[c] = value(matte.first_channel + c, i);
      matte.resolver.resolve(entries, ranks);
      for (std::size_t rank = 0; rank < matte.planes; ++rank)
        planes[(matte.first_plane + rank) * count + i] = ranks[rank];
    }
  }
  const std::span<float> samples = planes.last(count);
  for (std::size_t i = 0; i < count; ++i) samples[i] = static_cast<float>(sums.counts[begin + i]);
}

absl::Status Assembler::put_in_frame(const Tile& tile, const wire::TileResult& sums) {
  // The file has whole tiles, the frame in memory their rows.
  const std::size_t width = std::size_t(tile.pixels.width());
  const std::size_t count = file_ ? sums.pixel_count() : width;
  std::vector<float> planes(frame_.channels.size() * count);
  if (file_) {
    to_planes(sums, 0, count, planes);
    return file_->put(tile.pixels, planes);
  }
  for (std::int32_t y = tile.pixels.y0; y < tile.pixels.y1; ++y) {
    to_planes(sums, std::size_t(y - tile.pixels.y0) * width, width, planes);
    const std::size_t target = std::size_t(y - options_.crop.y0) * std::size_t(options_.crop.width()) +
                               std::size_t(tile.pixels.x0 - options_.crop.x0);
    for (std::size_t plane = 0; plane < frame_.channels.size(); ++plane) {
      std::copy_n(planes.data() + plane * width, width, frame_.channels[plane].values.data() + target);
    }
  }
  return absl::OkStatus();
}

void Assembler::list_missing(std::vector<Hole>& holes) const {
  for (std::size_t i = 0; i < owner_.size(); ++i) {
    if (owner_[i] == 0) holes.push_back({.pixels = file_->tile(i), .empty = true});
  }
}

void Assembler::mark_missing(std::vector<Hole>& holes) {
  const Window& crop = options_.crop;
  for (Channel& channel : frame_.channels) {
    if (!marks_holes(channel.name)) continue;
    for (std::size_t i = 0; i < owner_.size(); ++i) {
      const std::int32_t x = crop.x0 + static_cast<std::int32_t>(i) % crop.width();
      const std::int32_t y = crop.y0 + static_cast<std::int32_t>(i) / crop.width();
      if (owner_[i] == 0) channel.values[i] = hole_marker(x, y);
    }
  }
  for (std::int32_t y = crop.y0; y < crop.y1; ++y) {
    const std::uint32_t* const row = owner_.data() + std::ptrdiff_t(y - crop.y0) * crop.width();
    for (std::int32_t x = crop.x0; x < crop.x1;) {
      const std::int32_t begin = x;
      while (x < crop.x1 && row[x - crop.x0] == 0) ++x;
      if (x == begin) {
        ++x;
        continue;
      }
      // Rows of the same hole, one below the other, are one rectangle.
      const auto above = std::find_if(holes.begin(), holes.end(), [&](const Hole& hole) {
        return hole.empty && hole.pixels.y1 == y && hole.pixels.x0 == begin && hole.pixels.x1 == x;
      });
      if (above != holes.end()) {
        ++above->pixels.y1;
      } else {
        holes.push_back({.pixels = {begin, y, x, y + 1}, .empty = true});
      }
    }
  }
}

absl::StatusOr<Assembly> Assembler::finish() && {
  Assembly assembly;
  std::uint64_t whole_pixels = 0;
  for (Tile& tile : tiles_) {
    if (tile.whole) {
      whole_pixels += std::uint64_t(tile.pixels.width()) * std::uint64_t(tile.pixels.height());
      continue;
    }
    std::optional<wire::TileResult> sums;
    for (auto& [begin, node] : tile.nodes) {
      absl::StatusOr<wire::TileResult> part = store_.take(std::move(node.entry));
      if (!part.ok()) return part.status();
      if (sums) {
        merge_into(*sums, *part);
      } else {
        sums = *std::move(part);
      }
    }
    if (sums) {
      if (absl::Status status = put_in_frame(tile, *sums); !status.ok()) return status;
    }
    assembly.holes.push_back({.pixels = tile.pixels, .empty = false});
  }
  assembly.incomplete_pixels = frame_.pixel_count() - whole_pixels;
  if (assembly.incomplete_pixels > 0 && file_) list_missing(assembly.holes);
  if (assembly.incomplete_pixels > 0 && !file_) mark_missing(assembly.holes);
  if (!options_.samples_channel) frame_.channels.pop_back();
  for (const Matte& matte : mattes_) matte.resolver.describe(frame_);
  const auto shift = static_cast<std::int32_t>(options_.overscan);
  frame_.data = moved(frame_.data, -shift);
  frame_.display = {0, 0, frame_.display.x1 - 2 * shift, frame_.display.y1 - 2 * shift};
  assembly.image = std::move(frame_);
  assembly.rows = std::move(file_);
  return assembly;
}

}  // namespace tessera::client
