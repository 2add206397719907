// Hits of one material brought together: 16 paths that were neighbours on the screen are not after a bounce,
// and each material among them would be shaded with the lanes of the others idle.
#include <array>

#include "render/integrator/path/wavefront.h"

namespace tessera::render::TESSERA_ISA {

namespace {

/// The entries 0 .. count - 1, those of one group together and otherwise in their order; entries beyond are
/// valid ones. A counting sort; what met no surface is group 0.
void order_by_group(const std::vector<std::uint8_t>& group_of_shape, int groups,
                    const Lanes<std::int32_t>& shape, int count, Lanes<std::int32_t>& order,
                    std::uint8_t (&group_of)[kPadded]) {
  std::array<std::int32_t, kMostShadingGroups + 2>
      next{};  // next[g + 1] counts group g, then next[g] is its place
  for (int i = 0; i < count; ++i) {
    const int group = shape[i] < 0 ? 0 : group_of_shape[static_cast<std::size_t>(shape[i])] + 1;
    group_of[i] = static_cast<std::uint8_t>(group);
    if (group < groups) ++next[static_cast<std::size_t>(group) + 1];
  }
  for (int g = 1; g <= groups; ++g)
    next[static_cast<std::size_t>(g)] += next[static_cast<std::size_t>(g) - 1];
  for (int i = 0; i < count; ++i) order[next[group_of[i]]++] = i;
  Int(0).store_unaligned(order + count);
}

}  // namespace

void Wavefront::sort_by_group() {
  order_by_group(scene_.shading_group, scene_.shading_groups, hits_.shape, alive_, sorted_.order,
                 sorted_.group);
  for (int i = 0; i < alive_; i += kWidth) {
    const Int entry = Int::load(sorted_.order + i);
    const auto copy = [&](const auto& from, auto& to) { copy_lanes(from, entry, to, i); };
    PathState::for_each(scene_, copy, paths_, sorted_.paths);
    HitState::for_each(copy, hits_, sorted_.hits);
  }
}

}  // namespace tessera::render::TESSERA_ISA
