#include "render/film/pixel_order.h"

#include <algorithm>
#include <bit>

#include "base/split_mix.h"

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

std::vector<PixelPlace> groups_in(std::uint32_t left, std::uint32_t top, std::uint32_t width,
                                  std::uint32_t height, const PixelGroup& group) {
  const std::uint32_t cell_width = group.width * group.step, cell_height = group.height * group.step;
  const std::uint32_t pad_x = left % cell_width, pad_y = top % cell_height;
  const std::uint32_t columns = (pad_x + width + cell_width - 1) / cell_width;
  const std::uint32_t rows = (pad_y + height + cell_height - 1) / cell_height;
  const std::uint32_t size = group.width * group.height;
  const std::size_t packets = group.step * group.step * size / packet_of(group);
  // Blocks along the cell's upper and lower edge have one turn each.
  const auto drawn_at = [&](std::uint32_t i) {
    const std::uint32_t row = i / group.width;
    const bool at_edge = group.height > 2 && (row == 0 || row + 1 == group.height);
    return at_edge ? row * group.width : i;
  };
  std::vector<PixelPlace> places, pixels(packet_of(group));
  for (const std::uint32_t cell : z_order(columns, rows)) {
    const PixelPlace corner{cell % columns * cell_width - pad_x, cell / columns * cell_height - pad_y};
    const std::uint64_t drawn = base::split_mix(std::uint64_t{top + corner.y} << 32 | (left + corner.x));
    for (std::size_t packet = 0; packet < packets; ++packet) {
      bool any = false;
      for (std::uint32_t k = 0; k < pixels.size(); ++k) {
        const auto place = static_cast<std::uint32_t>(packet * pixels.size()) + k;
        const std::uint32_t column = place / size / group.step, row = place / size % group.step;
        const std::uint32_t i = place % size;
        const auto turn = static_cast<std::uint32_t>(drawn >> (4 * drawn_at(i)) & 0xf);
        pixels[k] = {corner.x + group.x(i) + column, corner.y + group.y(i) + (row + turn) % group.step};
        any |= pixels[k].x < width && pixels[k].y < height;
      }
      if (any) places.insert(places.end(), pixels.begin(), pixels.end());
    }
  }
  return places;
}

}  // namespace tessera::render
