// The order in which pixels are sampled: neighbours after each other, and groups of them whole.
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

/// Returns how many pixels are always sampled together: those of as many groups as fill a packet of 16 rays
/// and lie in one cell; one, where groups have one pixel. A ray that hits the edge between two triangles
/// meets one or the other by the rays that Embree traces with it, so the same 16 stay together in every
/// rectangle.
std::size_t packet_of(const PixelGroup& group);

/// Returns all pixels of the packets that have any in a rectangle of `width` x `height` pixels whose corner
/// is (left, top) on the film's grid, modulo 2^32; packet after packet, and in these group after group, in
/// cells along a Z-order curve.
///
/// A group's pixels lie in the same column of all blocks of the cell. The row is drawn by a hash for each
/// block, so that light which a group shares makes no regular pattern. Columns are not drawn, nor, of cells
/// more than two blocks high, rows of blocks along the upper and lower edge one by one, and a packet holds
/// groups of one column: fewer packets then reach into a border that is one pixel wide.
std::vector<PixelPlace> groups_in(std::uint32_t left, std::uint32_t top, std::uint32_t width,
                                  std::uint32_t height, const PixelGroup& group);

}  // namespace tessera::render
