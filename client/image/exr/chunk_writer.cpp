#include "image/exr/chunk_writer.h"

#include <Imath/half.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

namespace tessera::client {
namespace {

void to_half(std::span<const float> values, unsigned char* out) {
  for (const float value : values) {
    constexpr float kMax = 65504;
    const Imath::half half(std::isfinite(value) ? std::clamp(value, -kMax, kMax) : value);
    std::memcpy(out, &half, sizeof(half));
    out += sizeof(half);
  }
}

}  // namespace

std::int32_t lines_of_chunk(ExrCompression compression) {
  switch (compression) {
    case ExrCompression::kZip:
      return 16;
    case ExrCompression::kPiz:
    case ExrCompression::kDwaa:
      return 32;
    case ExrCompression::kDwab:
      return 256;
    default:
      return 1;
  }
}

exr_compression_t compression_of(ExrCompression compression) {
  switch (compression) {
    case ExrCompression::kNone:
      return EXR_COMPRESSION_NONE;
    case ExrCompression::kRle:
      return EXR_COMPRESSION_RLE;
    case ExrCompression::kZips:
      return EXR_COMPRESSION_ZIPS;
    case ExrCompression::kPiz:
      return EXR_COMPRESSION_PIZ;
    case ExrCompression::kDwaa:
      return EXR_COMPRESSION_DWAA;
    case ExrCompression::kDwab:
      return EXR_COMPRESSION_DWAB;
    default:
      return EXR_COMPRESSION_ZIP;
  }
}

ChunkWriter::ChunkWriter(const ExrFile& file, int index, const ExrPart& part)
    : file_(file), index_(index), part_(part), dwa_(part) {}

ChunkWriter::~ChunkWriter() {
  if (pipeline_) static_cast<void>(exr_encoding_destroy(file_.context(), &*pipeline_));
}

void ChunkWriter::append(std::span<const float> row, bool half) {
  static_assert(std::endian::native == std::endian::little);
  const std::size_t at = block_.size();
  block_.resize(at + row.size() * (half ? sizeof(Imath::half) : sizeof(float)));
  if (half) {
    to_half(row, block_.data() + at);
  } else {
    std::memcpy(block_.data() + at, row.data(), row.size_bytes());
  }
}

std::optional<std::span<const unsigned char>> ChunkWriter::packed(const exr_chunk_info_t& chunk) {
  switch (part_.compression) {
    case ExrCompression::kNone:
      return block_;
    case ExrCompression::kZip:
    case ExrCompression::kZips:
      return zip_.pack(block_);
    case ExrCompression::kDwaa:
    case ExrCompression::kDwab:
      return dwa_.pack(block_, chunk.width, chunk.height);
    default:
      return std::nullopt;
  }
}

void ChunkWriter::write_lines(std::int32_t y) {
  exr_chunk_info_t chunk;
  file_.check(exr_write_scanline_chunk_info(file_.context(), index_, y, &chunk));
  if (const auto bytes = packed(chunk)) {
    file_.check(exr_write_scanline_chunk(file_.context(), index_, y, bytes->data(), bytes->size()));
  } else {
    encode(chunk);
  }
  block_.clear();
}

void ChunkWriter::write_tile(const Tile& tile) {
  exr_chunk_info_t chunk;
  file_.check(
      exr_write_tile_chunk_info(file_.context(), index_, tile.x, tile.y, tile.level, tile.level, &chunk));
  if (const auto bytes = packed(chunk)) {
    file_.check(exr_write_tile_chunk(file_.context(), index_, tile.x, tile.y, tile.level, tile.level,
                                     bytes->data(), bytes->size()));
  } else {
    encode(chunk);
  }
  block_.clear();
}

void ChunkWriter::encode(const exr_chunk_info_t& chunk) {
  const exr_context_t context = file_.context();
  const bool first = !pipeline_;
  if (first) {
    pipeline_.emplace();
    *pipeline_ = EXR_ENCODE_PIPELINE_INITIALIZER;
    file_.check(exr_encoding_initialize(context, index_, &chunk, &*pipeline_));
  } else {
    file_.check(exr_encoding_update(context, index_, &chunk, &*pipeline_));
  }
  const auto width = static_cast<std::size_t>(chunk.width);
  const unsigned char* at = block_.data();
  for (std::size_t c = 0; c < part_.channels.size(); ++c) {
    exr_coding_channel_info_t& to = pipeline_->channels[c];
    const PartChannel& channel = part_.channels[c];
    to.encode_from_ptr = at;
    to.user_bytes_per_element = static_cast<std::int16_t>(channel.bytes());
    to.user_data_type = static_cast<std::uint16_t>(channel.half ? EXR_PIXEL_HALF : EXR_PIXEL_FLOAT);
    to.user_pixel_stride = static_cast<std::int32_t>(channel.bytes());
    to.user_line_stride = static_cast<std::int32_t>(width * part_.bytes());
    at += width * channel.bytes();
  }
  if (first) file_.check(exr_encoding_choose_default_routines(context, index_, &*pipeline_));
  file_.check(exr_encoding_run(context, index_, &*pipeline_));
}

}  // namespace tessera::client
