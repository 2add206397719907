// In which order pixels are sampled: neighbours after each other, and groups of them whole.
#pragma once

#include <cstddef>
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

/// Pixels of groups that are always sampled one after the other: groups of one pixel alone, else as many as
/// fill a packet of 16 rays and lie in one cell. Which of two triangles a ray meets that hits their edge
/// depends on the rays that Embree traces with it, so the same 16 are together whatever the rectangle.
std::size_t packet_of(const PixelGroup& group);

/// All pixels of the packets that have any in a rectangle of `width` x `height` pixels whose corner is (left,
/// top) on the film's grid, modulo 2^32; packet after packet, and in these group after group, in cells along
/// a Z-order curve.
///
/// A group has one pixel of each block of step x step in its cell, in the same column of all blocks; in which
/// row is drawn for each block, so that light which a group shares makes no regular pattern. Columns are
/// kept, and packets are of groups in one column, as what lies beyond the rectangle is taken, too: fewer
/// reach into a border of one column.
std::vector<PixelPlace> groups_in(std::uint32_t left, std::uint32_t top, std::uint32_t width,
                                  std::uint32_t height, const PixelGroup& group);

}  // namespace tessera::render
