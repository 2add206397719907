// In which order pixels are sampled: neighbours after each other, and groups of them whole.
#pragma once

#include <cstdint>
#include <vector>

#include "render/film/sample_source.h"

namespace tessera::render {

/// The pixels of a rectangle (indices, rows from the top) so that runs of 16, 64, 256 are squares.
std::vector<std::uint32_t> z_order(std::uint32_t width, std::uint32_t height);

/// A pixel relative to the upper left corner of a rectangle; modulo 2^32, beyond it.
struct PixelPlace {
  std::uint32_t x, y;
};

/// All pixels of the groups that have any in a rectangle of `width` x `height` pixels whose corner is (left,
/// top) on the film's grid, modulo 2^32; group after group, in cells along a Z-order curve.
///
/// A group has one pixel of each block of step x step in its cell, in the same column of all blocks; in which
/// row is drawn for each block, so that light which a group shares makes no regular pattern. Columns are kept
/// as what lies beyond the rectangle is taken, too: fewer groups reach into a border of one column.
std::vector<PixelPlace> groups_in(std::uint32_t left, std::uint32_t top, std::uint32_t width,
                                  std::uint32_t height, const PixelGroup& group);

}  // namespace tessera::render
