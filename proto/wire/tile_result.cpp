// Layout of the bytes, little endian [docs/decisions/0003-result-layout.md]:
//
//   header, in clear
//     char[8]  magic "TSRTILE1"
//     u32[6]   x0 y0 x1 y1 sample_begin sample_end
//     u32      channel count C
//     C times  u8 kind, u8 of, u8 length of the name, the name
//   one zstd frame with content size and checksum, of
//     the header once more, so that the checksum covers it
//     byte plane 0 of all words, byte plane 1, plane 2, plane 3;
//     words: u32 counts[pixels], f32 values[C][pixels]
//
// Results that stay within a process have the magic "TSRTILE0" and, behind the header, the words as they are.
//
// Planes of equal significance compress where whole floats do not: their exponents are alike, their mantissas
// are not.
#include "wire/tile_result.h"

#include <zstd.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstring>
#include <memory>
#include <new>

#include "absl/strings/str_cat.h"
#include "base/freer.h"

namespace tessera::wire {
namespace {

static_assert(std::endian::native == std::endian::little, "words are copied as they are");

constexpr char kMagic[] = "TSRTILE1";
constexpr char kPlainMagic[] = "TSRTILE0";
constexpr std::size_t kMagicBytes = 8;
constexpr std::size_t kFixedHeaderBytes = 8 + 7 * 4;
constexpr std::size_t kMaxNameBytes = 64;
constexpr int kCompressionLevel = 1;

absl::Status unsound(const std::string& what) {
  return absl::InvalidArgumentError(absl::StrCat("tile result: ", what));
}

using Compressor = std::unique_ptr<ZSTD_CCtx, base::Freer<ZSTD_freeCCtx>>;
using Decompressor = std::unique_ptr<ZSTD_DCtx, base::Freer<ZSTD_freeDCtx>>;

// Contexts are large; one a thread is made once and used for every tile.
ZSTD_CCtx* thread_compressor() {
  thread_local const Compressor context = [] {
    Compressor made(ZSTD_createCCtx());
    if (made == nullptr) throw std::bad_alloc();
    ZSTD_CCtx_setParameter(made.get(), ZSTD_c_compressionLevel, kCompressionLevel);
    ZSTD_CCtx_setParameter(made.get(), ZSTD_c_checksumFlag, 1);
    return made;
  }();
  return context.get();
}

ZSTD_DCtx* thread_decompressor() {
  thread_local const Decompressor context(ZSTD_createDCtx());
  if (context == nullptr) throw std::bad_alloc();
  return context.get();
}

std::string encode_header(const TileResult& result, Packing packing) {
  std::string header(packing == Packing::kZstd ? kMagic : kPlainMagic, kMagicBytes);
  const std::uint32_t fixed[7] = {result.x0,
                                  result.y0,
                                  result.x1,
                                  result.y1,
                                  result.sample_begin,
                                  result.sample_end,
                                  static_cast<std::uint32_t>(result.channels.size())};
  header.append(reinterpret_cast<const char*>(fixed), sizeof(fixed));
  for (const ChannelDesc& channel : result.channels) {
    assert(channel.name.size() <= kMaxNameBytes);
    header.push_back(static_cast<char>(channel.kind));
    header.push_back(static_cast<char>(channel.of));
    header.push_back(static_cast<char>(channel.name.size()));
    header += channel.name;
  }
  return header;
}

/// The channels from `first` on that are a list: all of it, and nothing else.
bool is_list(const std::vector<ChannelDesc>& channels, std::size_t first) {
  if (channels.size() - first < 2 * kListEntries) return false;
  for (std::size_t i = 0; i < 2 * kListEntries; ++i) {
    const ChannelDesc& channel = channels[first + i];
    if (channel.of != first || channel.kind != (i < 2 ? ChannelKind::kEntry : ChannelKind::kFurtherEntry))
      return false;
  }
  return true;
}

absl::Status check_channels(const std::vector<ChannelDesc>& channels) {
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const ChannelDesc& channel = channels[c];
    if (channel.kind == ChannelKind::kSum || channel.kind == ChannelKind::kFirst) continue;
    if (channel.kind == ChannelKind::kEntry) {
      if (!is_list(channels, c))
        return unsound(absl::StrCat("channel \"", channel.name, "\" begins no list of identifiers"));
      c += 2 * kListEntries - 1;
      continue;
    }
    if (channel.kind != ChannelKind::kSquaredDeviation) {
      return unsound(absl::StrCat("channel \"", channel.name, "\" is of an unknown kind"));
    }
    if (channel.of >= channels.size() || channels[channel.of].kind != ChannelKind::kSum) {
      return unsound(absl::StrCat("channel \"", channel.name, "\" belongs to no sum"));
    }
  }
  return absl::OkStatus();
}

bool is_plain(std::string_view bytes) { return std::memcmp(bytes.data(), kPlainMagic, kMagicBytes) == 0; }

/// Reads the header into `result`; returns its length.
absl::StatusOr<std::size_t> decode_header(std::string_view bytes, TileResult& result) {
  if (bytes.size() < kFixedHeaderBytes)
    return unsound(absl::StrCat(bytes.size(), " bytes are too few for the header"));
  if (std::memcmp(bytes.data(), kMagic, kMagicBytes) != 0 && !is_plain(bytes))
    return unsound("bad magic number");
  std::uint32_t fixed[7];
  std::memcpy(fixed, bytes.data() + 8, sizeof(fixed));
  result.x0 = fixed[0], result.y0 = fixed[1], result.x1 = fixed[2], result.y1 = fixed[3];
  result.sample_begin = fixed[4], result.sample_end = fixed[5];
  if (result.x1 <= result.x0 || result.y1 <= result.y0) return unsound("its rectangle is empty");
  if (result.sample_end <= result.sample_begin) return unsound("its sample range is empty");
  if (fixed[6] == 0 || fixed[6] > kMaxChannels)
    return unsound(absl::StrCat(fixed[6], " channels; 1 to ", kMaxChannels, " were expected"));

  std::size_t at = kFixedHeaderBytes;
  for (std::uint32_t c = 0; c < fixed[6]; ++c) {
    if (bytes.size() - at < 3) return unsound("the header ends within its channels");
    ChannelDesc channel;
    channel.kind = static_cast<ChannelKind>(bytes[at]);
    channel.of = static_cast<std::uint8_t>(bytes[at + 1]);
    const std::size_t length = static_cast<unsigned char>(bytes[at + 2]);
    at += 3;
    if (length > kMaxNameBytes || bytes.size() - at < length)
      return unsound("a channel's name is cut off or too long");
    channel.name = bytes.substr(at, length);
    at += length;
    result.channels.push_back(std::move(channel));
  }
  if (absl::Status status = check_channels(result.channels); !status.ok()) return status;
  return at;
}

/// Word i of `count` words, which come from two arrays, goes to planes[i], planes[i + count], ...
void split_planes(const std::uint32_t* words, std::size_t count, std::size_t first, std::size_t stride,
                  char* planes) {
  for (int plane = 0; plane < 4; ++plane) {
    char* const out = planes + plane * stride + first;
    for (std::size_t i = 0; i < count; ++i) out[i] = static_cast<char>(words[i] >> (8 * plane));
  }
}

void join_planes(const char* planes, std::size_t count, std::size_t first, std::size_t stride,
                 std::uint32_t* words) {
  const auto* const in = reinterpret_cast<const unsigned char*>(planes) + first;
  for (std::size_t i = 0; i < count; ++i) {
    words[i] = std::uint32_t{in[i]} | std::uint32_t{in[stride + i]} << 8 |
               std::uint32_t{in[2 * stride + i]} << 16 | std::uint32_t{in[3 * stride + i]} << 24;
  }
}

/// The words behind the header of a plain result.
absl::StatusOr<TileResult> decode_plain(std::string_view words, std::uint64_t count, TileResult result) {
  if (words.size() != 4 * count) return unsound("it does not have the size of its channels");
  result.counts.resize(result.pixel_count());
  result.values.resize(count - result.pixel_count());
  std::memcpy(result.counts.data(), words.data(), 4 * result.counts.size());
  std::memcpy(result.values.data(), words.data() + 4 * result.counts.size(), 4 * result.values.size());
  return result;
}

}  // namespace

bool are_siblings(std::uint32_t a_begin, std::uint32_t a_end, std::uint32_t b_begin, std::uint32_t b_end,
                  std::uint32_t spp) {
  if (a_end <= a_begin || b_end <= b_begin || b_begin != a_end) return false;
  // A node with a right sibling is whole: a power of two long, and the left one of its pair.
  const std::uint64_t length = a_end - a_begin;
  if (!std::has_single_bit(length) || a_begin % (2 * length) != 0) return false;
  return b_end == std::min<std::uint64_t>(a_begin + 2 * length, spp);
}

std::string encode_tile_result(const TileResult& result, Packing packing) {
  const std::size_t pixels = result.pixel_count();
  assert(result.counts.size() == pixels && result.values.size() == pixels * result.channels.size());
  const std::string header = encode_header(result, packing);
  const std::size_t words = result.counts.size() + result.values.size();
  if (packing == Packing::kNone) {
    std::string bytes;
    bytes.reserve(header.size() + 4 * words);
    bytes += header;
    bytes.append(reinterpret_cast<const char*>(result.counts.data()), 4 * result.counts.size());
    bytes.append(reinterpret_cast<const char*>(result.values.data()), 4 * result.values.size());
    return bytes;
  }
  std::string content(header.size() + 4 * words, '\0');
  std::memcpy(content.data(), header.data(), header.size());
  std::vector<std::uint32_t> values(result.values.size());
  std::memcpy(values.data(), result.values.data(), 4 * values.size());
  char* const planes = content.data() + header.size();
  split_planes(result.counts.data(), pixels, 0, words, planes);
  split_planes(values.data(), values.size(), pixels, words, planes);

  std::string bytes = header;
  bytes.resize(header.size() + ZSTD_compressBound(content.size()));
  const std::size_t size = ZSTD_compress2(thread_compressor(), bytes.data() + header.size(),
                                          bytes.size() - header.size(), content.data(), content.size());
  if (ZSTD_isError(size)) throw std::bad_alloc();  // the bound holds, so only memory can be missing
  bytes.resize(header.size() + size);
  return bytes;
}

absl::StatusOr<TileResult> decode_tile_result(std::string_view bytes, std::size_t max_pixels,
                                              std::size_t max_channels) {
  TileResult result;
  const absl::StatusOr<std::size_t> header_size = decode_header(bytes, result);
  if (!header_size.ok()) return header_size.status();
  const std::uint64_t pixels = std::uint64_t{result.x1 - result.x0} * (result.y1 - result.y0);
  if (pixels > max_pixels) {
    return unsound(absl::StrCat(pixels, " pixels, where at most ", max_pixels, " were expected"));
  }
  if (result.channels.size() > max_channels) {
    return unsound(
        absl::StrCat(result.channels.size(), " channels, where at most ", max_channels, " were expected"));
  }

  const std::uint64_t words = pixels * (1 + result.channels.size());
  if (is_plain(bytes)) return decode_plain(bytes.substr(*header_size), words, std::move(result));

  // The frame must say by itself that it holds just what the header promises, before anything is allocated.
  const std::string_view frame = bytes.substr(*header_size);
  const unsigned long long content_size = ZSTD_getFrameContentSize(frame.data(), frame.size());
  if (content_size != *header_size + 4 * words)
    return unsound("the compressed part does not have the size of its channels");
  std::string content(content_size, '\0');
  const std::size_t size =
      ZSTD_decompressDCtx(thread_decompressor(), content.data(), content.size(), frame.data(), frame.size());
  if (ZSTD_isError(size))
    return unsound(absl::StrCat("the compressed part is damaged: ", ZSTD_getErrorName(size)));
  if (size != content.size() || content.compare(0, *header_size, bytes.substr(0, *header_size)) != 0) {
    return unsound("the header is damaged");
  }

  const char* const planes = content.data() + *header_size;
  result.counts.resize(pixels);
  join_planes(planes, pixels, 0, words, result.counts.data());
  std::vector<std::uint32_t> values(words - pixels);
  join_planes(planes, values.size(), pixels, words, values.data());
  result.values.resize(values.size());
  std::memcpy(result.values.data(), values.data(), 4 * values.size());
  return result;
}

}  // namespace tessera::wire
