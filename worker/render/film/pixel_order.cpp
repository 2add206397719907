#include "render/film/pixel_order.h"

#include <algorithm>
#include <bit>

#include "base/split_mix.h"
#include "render/film/common_places.h"

namespace tessera::render {

std::vector<std::uint32_t> z_order(std::uint32_t width, std::uint32_t height) {
  std::vector<std::uint32_t> order;
  order.reserve(std::size_t{width} * height);
  const std::uint32_t side = std::bit_ceil(std::max({width, height, 1u}));
  const auto every_second_bit = [](std::uint64_t code) {
    code &= 0x5555555555555555;
    code = (code | code >> 1) & 0x3333333333333333;
    code = (code | code >> 2) & 0x0f0f0f0f0f0f0f0f;
    code = (code | code >> 4) & 0x00ff00ff00ff00ff;
    code = (code | code >> 8) & 0x0000ffff0000ffff;
    return static_cast<std::uint32_t>(code | code >> 16);
  };
  for (std::uint64_t code = 0; code < std::uint64_t{side} * side; ++code) {
    const std::uint32_t x = every_second_bit(code), y = every_second_bit(code >> 1);
    if (x < width && y < height) order.push_back(y * width + x);
  }
  return order;
}

std::size_t packet_of(const PixelGroup& group) {
  constexpr std::uint32_t kRays = 16;
  const auto size = static_cast<std::uint32_t>(group.count());
  return size * std::clamp(kRays / size, 1u, group.step * group.step);
}

GroupGrid grid_of(const PixelGroup& group, std::uint64_t seed, std::uint32_t sample) {
  if (group.count() == 1) return {};
  // Apart from the places of samples, which have the seed as it is.
  const std::uint64_t own = base::split_mix(seed ^ 0x67726f757073);
  const Place place = scrambled_place(own, sample);
  const auto step = [](float part, std::uint32_t side) {
    return static_cast<std::uint32_t>(part * static_cast<float>(side));
  };
  return {step(place.x, cell_width_of(group)), step(place.y, cell_height_of(group)),
          base::split_mix(own + sample)};
}

std::vector<PixelPlace> groups_in(std::uint32_t left, std::uint32_t top, std::uint32_t width,
                                  std::uint32_t height, const PixelGroup& group, const GroupGrid& grid) {
  // Borders are in the first cell, and numbers are modulo 2^32, so rectangles may begin before the film.
  const std::uint32_t cell_width = cell_width_of(group), cell_height = cell_height_of(group);
  const auto before = [](std::uint32_t place, std::uint32_t offset, std::uint32_t side) {
    const std::int64_t from_corner = std::int64_t{static_cast<std::int32_t>(place)} - offset;
    return static_cast<std::uint32_t>((from_corner % side + side) % side);
  };
  const std::uint32_t pad_x = before(left, grid.x, cell_width), pad_y = before(top, grid.y, cell_height);
  const std::uint32_t columns = (pad_x + width + cell_width - 1) / cell_width;
  const std::uint32_t rows = (pad_y + height + cell_height - 1) / cell_height;
  const std::uint32_t size = group.width * group.height, steps = group.step * group.step;
  const auto packet = static_cast<std::uint32_t>(packet_of(group));
  std::vector<PixelPlace> places, turns(size), pixels(std::size_t{steps} * size);
  places.reserve(std::size_t{columns} * rows * pixels.size());
  for (const std::uint32_t cell : z_order(columns, rows)) {
    const PixelPlace corner{cell % columns * cell_width - pad_x, cell / columns * cell_height - pad_y};
    std::uint64_t drawn =
        base::split_mix(grid.draw ^ (std::uint64_t{top + corner.y} << 32 | (left + corner.x)));
    for (PixelPlace& turn : turns) {
      const auto below_step = [&](std::uint64_t bits) {
        return static_cast<std::uint32_t>((bits & 0xffffffff) * group.step >> 32);
      };
      turn = {below_step(drawn), below_step(drawn >> 32)};
      drawn = base::split_mix(drawn);
    }
    for (std::uint32_t k = 0; k < pixels.size(); ++k) {
      const std::uint32_t number = k / size, i = k % size;
      const std::uint32_t block_x = (number % group.step + turns[i].x) % group.step,
                          block_y = (number / group.step + turns[i].y) % group.step;
      pixels[k] = {corner.x + block_x * group.width + i % group.width,
                   corner.y + block_y * group.height + i / group.width};
    }
    for (auto first = pixels.begin(); first != pixels.end(); first += packet) {
      if (std::any_of(first, first + packet,
                      [&](const PixelPlace& place) { return place.x < width && place.y < height; }))
        places.insert(places.end(), first, first + packet);
    }
  }
  return places;
}

}  // namespace tessera::render
