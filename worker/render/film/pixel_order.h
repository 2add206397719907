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

inline std::uint32_t cell_width_of(const PixelGroup& group) { return group.width * group.step; }
inline std::uint32_t cell_height_of(const PixelGroup& group) { return group.height * group.step; }

/// Where the cells of groups lie on the film's grid, and which pixels of a cell are one group, for the
/// samples of one number.
struct GroupGrid {
  std::uint32_t x = 0, y = 0;  // the upper left corner of a cell, below the cell's size
  std::uint64_t draw = 0;
};

/// Returns the grid of a sample's number. Over the numbers, corners are the points of a (0,2)-sequence: each
/// pixel has been at all places of a cell equally often, so what groups have in common makes no pattern.
GroupGrid grid_of(const PixelGroup& group, std::uint64_t seed, std::uint32_t sample);

/// Returns all pixels of the packets that have any in a rectangle of `width` x `height` pixels whose corner
/// is (left, top) on the film's grid, modulo 2^32 (below 2^31 either side); packet after packet, and in these
/// group after group, in cells along a Z-order curve.
std::vector<PixelPlace> groups_in(std::uint32_t left, std::uint32_t top, std::uint32_t width,
                                  std::uint32_t height, const PixelGroup& group, const GroupGrid& grid = {});

}  // namespace tessera::render
