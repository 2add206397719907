// Hits of one material brought together: 16 paths that were neighbours on the screen are not after a bounce,
// and each material among them would be shaded with the lanes of the others idle. A counting sort; what met
// no surface is group 0.
#include <array>

#include "render/transport/path/wavefront.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// Where the next entry of each group goes.
using Places = std::array<std::int32_t, kMostShadingGroups + 2>;

/// Sets the groups of the entries 0 .. count - 1; returns where those of each begin.
Places count_groups(const std::vector<std::uint8_t>& group_of_shape, int groups,
                    const Lanes<std::int32_t>& shape, int count, Lanes<std::int32_t>& group_of) {
  Places next{};  // next[g + 1] counts group g, then next[g] is its place
  for (int i = 0; i < count; ++i) {
    const int group = shape[i] < 0 ? 0 : group_of_shape[static_cast<std::size_t>(shape[i])] + 1;
    group_of[i] = group;
    if (group < groups) ++next[static_cast<std::size_t>(group) + 1];
  }
  for (int g = 1; g <= groups; ++g)
    next[static_cast<std::size_t>(g)] += next[static_cast<std::size_t>(g) - 1];
  return next;
}

/// The entries 0 .. count - 1, those of one group together and otherwise in their order; entries beyond are
/// valid ones.
void order_by_group(const Lanes<std::int32_t>& group_of, int count, Places& next,
                    Lanes<std::int32_t>& order) {
  for (int i = 0; i < count; ++i) order[next[static_cast<std::size_t>(group_of[i])]++] = i;
  Int(0).store_unaligned(order + count);
}

/// The active ones of 16 entries from entry i on become those from entry `at` on.
template <class Memory>
TESSERA_INLINE void pack_lanes(const Memory& from, int i, Mask active, Memory& to, int at) {
  for_each_component(
      [&](const auto& source, auto& lanes) {
        using Number = std::decay_t<decltype(source[0])>;
        compress_store(Wide<Number>::load(&source[0] + i), active, &lanes[0] + at);
      },
      from, to);
}

/// 16 entries from entry i on become zeros.
template <class Memory>
TESSERA_INLINE void clear_lanes(Memory& to, int i) {
  for_each_component(
      [&](auto& lanes) {
        using Number = std::decay_t<decltype(lanes[0])>;
        Wide<Number>(Number{0}).store_unaligned(&lanes[0] + i);
      },
      to);
}

}  // namespace

void Wavefront::sort_by_group() {
  Places next = count_groups(scene_.shading_group, scene_.shading_groups, hits_.shape, alive_, sorted_.group);
  if constexpr (kParts == 1) {  // packing lanes is an instruction
    for (int i = 0; i < alive_; i += kWidth) {
      for_each_distinct(Int::load(sorted_.group + i), Mask::first(alive_ - i), [&](int group, Mask lanes) {
        std::int32_t& place = next[static_cast<std::size_t>(group)];
        const auto pack = [&](const auto& from, auto& to) { pack_lanes(from, i, lanes, to, place); };
        PathState::for_each(scene_, pack, paths_, sorted_.paths);
        HitState::for_each(pack, hits_, sorted_.hits);
        place += count(lanes);
      });
    }
    const auto clear = [&](auto& beyond) { clear_lanes(beyond, alive_); };
    PathState::for_each(scene_, clear, sorted_.paths);
    HitState::for_each(clear, sorted_.hits);
    return;
  }
  order_by_group(sorted_.group, alive_, next, sorted_.order);
  for (int i = 0; i < alive_; i += kWidth) {
    const Int entry = Int::load(sorted_.order + i);
    const auto copy = [&](const auto& from, auto& to) { copy_lanes(from, entry, to, i); };
    PathState::for_each(scene_, copy, paths_, sorted_.paths);
    HitState::for_each(copy, hits_, sorted_.hits);
  }
}

}  // namespace tessera::render::TESSERA_ISA
