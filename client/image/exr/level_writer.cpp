#include "image/exr/level_writer.h"

#include <algorithm>
#include <span>

namespace tessera::client {

LevelWriter::LevelWriter(ChunkWriter& chunks, const ExrPart& part, std::int32_t width, std::int32_t height,
                         std::int32_t tile_size, bool mipmaps)
    : chunks_(chunks), part_(part), tile_size_(tile_size) {
  levels_.push_back({.width = width, .height = height});
  while (mipmaps && std::max(width, height) > 1) {
    width = std::max(width / 2, 1), height = std::max(height / 2, 1);
    levels_.push_back({.width = width, .height = height});
  }
}

void LevelWriter::add(std::size_t number, const Row& row) {
  Level& level = levels_[number];
  level.band.push_back(row);
  ++level.rows_added;
  if (static_cast<std::int32_t>(level.band.size()) == tile_size_ || level.rows_added == level.height)
    write_band(number);
  if (number + 1 == levels_.size()) return;
  if (level.height == 1) {
    add(number + 1, halved(level, row, row));
  } else if (level.rows_added % 2 == 1) {
    level.above = row;
  } else {
    add(number + 1, halved(level, level.above, row));
  }
}

void LevelWriter::write_band(std::size_t number) {
  Level& level = levels_[number];
  const std::int32_t y = (level.rows_added - 1) / tile_size_;
  for (std::int32_t x = 0; x * tile_size_ < level.width; ++x) {
    const auto begin = static_cast<std::size_t>(x * tile_size_);
    const auto width = static_cast<std::size_t>(std::min(tile_size_, level.width - x * tile_size_));
    for (const Row& row : level.band) {
      for (std::size_t c = 0; c < part_.channels.size(); ++c)
        chunks_.append(std::span(row[c]).subspan(begin, width), part_.channels[c].half);
    }
    chunks_.write_tile({x, y, static_cast<std::int32_t>(number)});
  }
  level.band.clear();
}

LevelWriter::Row LevelWriter::halved(const Level& from, const Row& above, const Row& below) const {
  const auto width = static_cast<std::size_t>(std::max(from.width / 2, 1));
  const std::size_t right = from.width > 1 ? 1 : 0;
  Row result(part_.channels.size(), std::vector<float>(width));
  for (std::size_t c = 0; c < result.size(); ++c) {
    for (std::size_t x = 0; x < width; ++x) {
      const std::size_t left = 2 * x;
      result[c][x] = part_.channels[c].averages ? 0.25f * ((above[c][left] + above[c][left + right]) +
                                                           (below[c][left] + below[c][left + right]))
                                                : above[c][left];
    }
  }
  return result;
}

}  // namespace tessera::client
