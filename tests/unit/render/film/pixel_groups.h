// The group that a pixel belongs to.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "render/film/pixel_order.h"

namespace tessera::render::test {

/// Side by side, and spread.
inline constexpr PixelGroup kGroups[] = {{2, 2}, {4, 2}, {4, 4}, {2, 2, 2}, {4, 2, 2}, {4, 4, 2}};

/// Numbers of the groups of pixels of a small film and of a border around it.
class GroupMap {
 public:
  explicit GroupMap(const PixelGroup& group, const GroupGrid& grid = {}) {
    const std::vector<PixelPlace> places = groups_in(0 - kBorder, 0 - kBorder, kSide, kSide, group, grid);
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (places[i].x < kSide && places[i].y < kSide)
        groups_[places[i].y * kSide + places[i].x] = i / static_cast<std::size_t>(group.count());
    }
  }

  std::size_t of(const SampleName& name) const {
    return groups_.at((name.y + kBorder) * kSide + name.x + kBorder);
  }

 private:
  static constexpr std::uint32_t kBorder = 16, kSide = 128;
  std::vector<std::size_t> groups_ = std::vector<std::size_t>(std::size_t{kSide} * kSide);
};

}  // namespace tessera::render::test
