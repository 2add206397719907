// Parts a set where the surface area heuristic expects least cost: by twelve buckets [Wald2007; Pharr2023,
// sec. 7.3.2], by an exact sweep over all ways to part the sorted set where it is small.
#include <array>
#include <cmath>

#include "render/accel/bvh/bvh.h"

namespace tessera::render {

namespace {

constexpr int kBuckets = 12;

struct BvhSplit {
  double cost = std::numeric_limits<double>::infinity();  // of the two halves, times the area of the whole
  int axis = -1;
  std::size_t left = 0;  // the last bucket on the left
};

/// Numbers of buckets, of places between those of the lowest and of the highest centre.
class BucketScale {
 public:
  explicit BucketScale(const Box& centres) {
    for (int k = 0; k < 3; ++k) {
      low_[k] = centres.low[k];
      const auto scale = static_cast<float>(kBuckets / centres.extent(k));
      scale_[k] = centres.extent(k) > 0 && std::isfinite(scale) ? scale : 0;
    }
  }
  bool parts(int axis) const { return scale_[axis] > 0; }
  std::size_t operator()(const BvhRef& ref, int axis) const {
    const float place = (ref.box.centre(axis) - low_[axis]) * scale_[axis];
    return static_cast<std::size_t>(std::min(kBuckets - 1.0f, place));
  }

 private:
  float low_[3], scale_[3];
};

BvhSplit by_buckets(std::span<const BvhRef> refs, const BucketScale& bucket) {
  struct Bucket {
    WideBox box;
    std::size_t count = 0;
  };
  std::array<std::array<Bucket, kBuckets>, 3> buckets;
  for (const BvhRef& ref : refs) {
    for (int axis = 0; axis < 3; ++axis) {
      Bucket& in = buckets[static_cast<std::size_t>(axis)][bucket(ref, axis)];
      in.box.add(ref.box);
      ++in.count;
    }
  }
  BvhSplit best;
  for (int axis = 0; axis < 3; ++axis) {
    if (!bucket.parts(axis)) continue;
    const auto& along = buckets[static_cast<std::size_t>(axis)];
    std::array<double, kBuckets> right_cost{};
    Box box;
    std::size_t count = 0;
    for (std::size_t b = kBuckets - 1; b > 0; --b) {
      box.add(along[b].box.box());
      count += along[b].count;
      right_cost[b] = box.area() * static_cast<double>(count);
    }
    box = {}, count = 0;
    for (std::size_t b = 0; b + 1 < kBuckets; ++b) {
      box.add(along[b].box.box());
      count += along[b].count;
      const double cost = box.area() * static_cast<double>(count) + right_cost[b + 1];
      if (count > 0 && count < refs.size() && cost < best.cost) best = {cost, axis, b};
    }
  }
  return best;
}

}  // namespace

bool is_worth_parting(std::size_t n, double area, double cost_of_halves) {
  return n > kMostInLeaf ||
         kStepCost * area + kTestCost * cost_of_halves < kTestCost * area * static_cast<double>(n);
}

std::size_t part_by_sah(std::span<BvhRef> refs, const BvhBounds& bounds, BvhBounds (&halves)[2]) {
  const BucketScale bucket(bounds.centres);
  const BvhSplit split = by_buckets(refs, bucket);
  // Primitives that share one centre are halved by number.
  if (split.axis < 0) {
    if (refs.size() <= kMostInLeaf) return 0;
    const std::size_t left = part_at_median(refs, bounds.centres);
    halves[0] = bounds_of(refs.first(left)), halves[1] = bounds_of(refs.subspan(left));
    return left;
  }
  if (!is_worth_parting(refs.size(), bounds.box.area(), split.cost)) return 0;
  // Each ref is read once: to find its side, and to add it to that side's bounds.
  WideBounds sums[2];
  const auto is_left = [&](const BvhRef& ref) { return bucket(ref, split.axis) <= split.left; };
  auto left = refs.begin(), right = refs.end();
  for (;;) {
    for (; left != right && is_left(*left); ++left) sums[0].add(*left);
    if (left == right) break;
    for (--right; left != right && !is_left(*right); --right) sums[1].add(*right);
    sums[1].add(*left);
    if (left == right) break;
    sums[0].add(*right);
    std::swap(*left++, *right);
  }
  halves[0] = sums[0].bounds(), halves[1] = sums[1].bounds();
  return static_cast<std::size_t>(left - refs.begin());
}

SweptSet::SweptSet(std::span<BvhRef> refs) : refs_(refs) {
  std::ranges::copy(refs, copies_.begin());
  struct Place {
    float centre;
    std::uint32_t index;
    std::uint8_t ref;
  };
  std::array<Place, kSweptSize> places;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < refs.size(); ++i) {
      places[i] = {refs[i].box.centre(static_cast<int>(axis)), refs[i].index, static_cast<std::uint8_t>(i)};
    }
    std::sort(places.begin(), places.begin() + static_cast<std::ptrdiff_t>(refs.size()),
              [](const Place& a, const Place& b) {
                return a.centre != b.centre ? a.centre < b.centre : a.index < b.index;
              });
    for (std::size_t i = 0; i < refs.size(); ++i) order_[axis][i] = places[i].ref;
  }
}

Box SweptSet::box_of(std::size_t first, std::size_t n) const {
  WideBox box;
  for (std::size_t i = first; i < first + n; ++i) box.add(copies_[order_[0][i]].box);
  return box.box();
}

std::size_t SweptSet::part(std::size_t first, std::size_t n, const Box& box) {
  double least = std::numeric_limits<double>::infinity();
  std::size_t axis = 0, left_count = 0;
  std::array<double, kSweptSize> right_area;
  for (std::size_t a = 0; a < 3; ++a) {
    const std::uint8_t* const order = order_[a].data() + first;
    WideBox right;
    for (std::size_t i = n - 1; i > 0; --i) {
      right.add(copies_[order[i]].box);
      right_area[i] = right.box().area();
    }
    WideBox left;
    for (std::size_t i = 1; i < n; ++i) {
      left.add(copies_[order[i - 1]].box);
      const double cost =
          left.box().area() * static_cast<double>(i) + right_area[i] * static_cast<double>(n - i);
      if (cost < least) least = cost, axis = a, left_count = i;
    }
  }
  if (left_count == 0 || !is_worth_parting(n, box.area(), least)) return 0;
  part_along(axis, first, n, left_count);
  return left_count;
}

std::size_t SweptSet::halve(std::size_t first, std::size_t n) {
  Box centres;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    centres.low[axis] = copies_[order_[axis][first]].box.centre(static_cast<int>(axis));
    centres.high[axis] = copies_[order_[axis][first + n - 1]].box.centre(static_cast<int>(axis));
  }
  part_along(static_cast<std::size_t>(centres.longest_axis()), first, n, n / 2);
  return n / 2;
}

void SweptSet::part_along(std::size_t axis, std::size_t first, std::size_t n, std::size_t left) {
  std::array<bool, kSweptSize> is_left{};
  for (std::size_t i = first; i < first + left; ++i) is_left[order_[axis][i]] = true;
  for (std::size_t a = 0; a < 3; ++a) {
    if (a == axis) continue;
    std::array<std::uint8_t, kSweptSize> rest;
    std::size_t kept = first, others = 0;
    for (std::size_t i = first; i < first + n; ++i) {
      const std::uint8_t ref = order_[a][i];
      (is_left[ref] ? order_[a][kept++] : rest[others++]) = ref;
    }
    std::copy_n(rest.begin(), others, order_[a].begin() + static_cast<std::ptrdiff_t>(kept));
  }
}

void SweptSet::put_back(std::size_t first, std::size_t n) {
  for (std::size_t i = first; i < first + n; ++i) refs_[i] = copies_[order_[0][i]];
}

}  // namespace tessera::render
