// Parts a set where the surface area heuristic expects least cost: by twelve buckets [Wald2007; Pharr2023,
// sec. 7.3.2], by an exact sweep over all ways to part the sorted set where it is small.
#include <array>

#include "render/accel/bvh/bvh.h"

namespace tessera::render {

namespace {

constexpr int kBuckets = 12;
/// Sets up to this size are swept.
constexpr std::size_t kSweptSize = 64;

struct BvhSplit {
  double cost = std::numeric_limits<double>::infinity();  // of the two halves, times the area of the whole
  int axis = -1;
  std::size_t left = 0;  // primitives on the left; of the buckets, the last one on the left
};

bool less_along(int axis, const BvhRef& a, const BvhRef& b) {
  const float ca = a.box.centre(axis), cb = b.box.centre(axis);
  return ca != cb ? ca < cb : a.index < b.index;
}

BvhSplit sweep(std::span<BvhRef> refs) {
  BvhSplit best;
  std::array<double, kSweptSize> right_area;
  for (int axis = 0; axis < 3; ++axis) {
    std::ranges::sort(refs, [axis](const BvhRef& a, const BvhRef& b) { return less_along(axis, a, b); });
    Box box;
    for (std::size_t i = refs.size() - 1; i > 0; --i) {
      box.add(refs[i].box);
      right_area[i] = box.area();
    }
    box = {};
    for (std::size_t i = 1; i < refs.size(); ++i) {
      box.add(refs[i - 1].box);
      const double cost =
          box.area() * static_cast<double>(i) + right_area[i] * static_cast<double>(refs.size() - i);
      if (cost < best.cost) best = {cost, axis, i};
    }
  }
  return best;
}

std::size_t bucket_of(const BvhRef& ref, const Box& centres, int axis) {
  const double place = (double{ref.box.centre(axis)} - centres.low[axis]) / centres.extent(axis);
  return std::min<std::size_t>(kBuckets - 1, static_cast<std::size_t>(kBuckets * place));
}

BvhSplit by_buckets(std::span<const BvhRef> refs, const Box& centres) {
  BvhSplit best;
  for (int axis = 0; axis < 3; ++axis) {
    if (!(centres.extent(axis) > 0)) continue;
    std::array<Box, kBuckets> boxes;
    std::array<std::size_t, kBuckets> counts{};
    for (const BvhRef& ref : refs) {
      const std::size_t b = bucket_of(ref, centres, axis);
      boxes[b].add(ref.box);
      ++counts[b];
    }
    std::array<double, kBuckets> right_cost{};
    Box box;
    std::size_t count = 0;
    for (std::size_t b = kBuckets - 1; b > 0; --b) {
      box.add(boxes[b]);
      count += counts[b];
      right_cost[b] = box.area() * static_cast<double>(count);
    }
    box = {}, count = 0;
    for (std::size_t b = 0; b + 1 < kBuckets; ++b) {
      box.add(boxes[b]);
      count += counts[b];
      const double cost = box.area() * static_cast<double>(count) + right_cost[b + 1];
      if (count > 0 && count < refs.size() && cost < best.cost) best = {cost, axis, b};
    }
  }
  return best;
}

}  // namespace

std::size_t part_by_sah(std::span<BvhRef> refs, const Box& box, const Box& centres) {
  const bool swept = refs.size() <= kSweptSize;
  const BvhSplit split = swept ? sweep(refs) : by_buckets(refs, centres);
  // Primitives that share one centre are halved by number.
  if (split.axis < 0) return refs.size() <= kMostInLeaf ? 0 : part_at_median(refs, centres);
  const double area = box.area();
  const double parted = kStepCost * area + kTestCost * split.cost;
  if (refs.size() <= kMostInLeaf && parted >= kTestCost * area * static_cast<double>(refs.size())) return 0;
  if (swept) {
    std::ranges::nth_element(refs, refs.begin() + static_cast<std::ptrdiff_t>(split.left),
                             [&](const BvhRef& a, const BvhRef& b) { return less_along(split.axis, a, b); });
    return split.left;
  }
  const auto right = std::stable_partition(refs.begin(), refs.end(), [&](const BvhRef& ref) {
    return bucket_of(ref, centres, split.axis) <= split.left;
  });
  return static_cast<std::size_t>(right - refs.begin());
}

}  // namespace tessera::render
