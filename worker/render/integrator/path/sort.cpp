// Hits of one material brought together: 16 paths that were neighbours on the screen are not after a bounce, and each
// material among them would be shaded with the lanes of the others idle.
#include <array>

#include "render/integrator/path/wavefront.h"

namespace tessera::render::TESSERA_ISA {

namespace {

template <class T>
TESSERA_INLINE void copy(const Lanes<T>& from, Int index, Lanes<T>& to, int i) {
  gather(&from[0], index).store(to + i);
}
TESSERA_INLINE void copy(const Vec3Lanes& from, Int index, Vec3Lanes& to, int i) {
  copy(from.x, index, to.x, i);
  copy(from.y, index, to.y, i);
  copy(from.z, index, to.z, i);
}

/// The entries 0 .. count - 1, those of one group together and otherwise in their order; entries beyond are valid ones.
/// A counting sort; what met no surface is group 0.
void order_by_group(const std::vector<std::uint8_t>& group_of_shape, int groups, const Lanes<std::int32_t>& shape,
                    int count, SortedState& sorted) {
  std::array<std::int32_t, kMostShadingGroups + 2> next{};  // next[g + 1] counts group g, then next[g] is its place
  for (int i = 0; i < count; ++i) {
    const int group = shape[i] < 0 ? 0 : group_of_shape[static_cast<std::size_t>(shape[i])] + 1;
    sorted.group[i] = static_cast<std::uint8_t>(group);
    if (group < groups) ++next[static_cast<std::size_t>(group) + 1];
  }
  for (int g = 1; g <= groups; ++g) next[static_cast<std::size_t>(g)] += next[static_cast<std::size_t>(g) - 1];
  for (int i = 0; i < count; ++i) sorted.order[next[sorted.group[i]]++] = i;
  Int(0).store_unaligned(sorted.order + count);
}

}  // namespace

void Wavefront::sort_by_group() {
  order_by_group(scene_.shading_group, scene_.shading_groups, hits_.shape, alive_, sorted_);
  PathState& to = sorted_.paths;
  for (int i = 0; i < alive_; i += kWidth) {
    const Int entry = Int::load(sorted_.order + i);
    copy(paths_.origin, entry, to.origin, i);
    copy(paths_.direction, entry, to.direction, i);
    for (int c = 0; c < kSpectrumLanes; ++c) copy(paths_.beta.c[c], entry, to.beta.c[c], i);
    copy(paths_.pdf, entry, to.pdf, i);
    copy(paths_.eta_scale, entry, to.eta_scale, i);
    copy(paths_.slot, entry, to.slot, i);
    if (scene_.lights.uses_normals) copy(paths_.normal, entry, to.normal, i);
    if (scene_.any_motion) copy(paths_.time, entry, to.time, i);
    if (scene_.volumetric) {
      copy(paths_.reference, entry, to.reference, i);
      copy(paths_.medium, entry, to.medium, i);
    }
    copy(hits_.t, entry, sorted_.hits.t, i);
    copy(hits_.u, entry, sorted_.hits.u, i);
    copy(hits_.v, entry, sorted_.hits.v, i);
    copy(hits_.primitive, entry, sorted_.hits.primitive, i);
    copy(hits_.shape, entry, sorted_.hits.shape, i);
    copy(hits_.instance, entry, sorted_.hits.instance, i);
  }
}

}  // namespace tessera::render::TESSERA_ISA
