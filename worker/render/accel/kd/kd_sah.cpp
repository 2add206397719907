// The plane of least expected cost among all where a primitive's part begins or ends [Wald2006]: between two
// of those, cost has no minimum. A plane that cuts off empty space costs a fifth less.
#include <array>
#include <bit>
#include <utility>

#include "render/accel/kd/kd_tree.h"
#include "render/core/stopped.h"

namespace tessera::render {

namespace {

constexpr double kEmptyBonus = 0.8;

/// Sorts in a time in proportion to their number, so that all cells of a level take no longer than all
/// primitives do: by digits of eleven bits, from the last to the first.
void sort_places(std::vector<float>& places, std::vector<std::uint32_t>& keys,
                 std::vector<std::uint32_t>& other, const std::stop_token& stop) {
  constexpr std::size_t kFew = 512;  // std::sort is as fast below
  if (places.size() < kFew) {
    std::ranges::sort(places);
    return;
  }
  constexpr std::uint32_t kDigit = 2048, kSign = 0x80000000u;
  keys.resize(places.size()), other.resize(places.size());
  std::array<std::array<std::uint32_t, kDigit>, 3> firsts{};
  for (std::size_t i = 0; i < places.size(); ++i) {
    throw_if_stopped(stop, i);
    // Bits of floats are in order once those of negative ones are turned over. -0 is 0.
    const auto bits = std::bit_cast<std::uint32_t>(places[i] + 0.0f);
    const std::uint32_t key = keys[i] = (bits & kSign) != 0 ? ~bits : bits | kSign;
    for (std::size_t d = 0; d < 3; ++d) ++firsts[d][key >> (11 * d) & (kDigit - 1)];
  }
  for (std::size_t d = 0; d < 3; ++d) {
    std::uint32_t sum = 0;
    for (std::uint32_t& first : firsts[d]) sum += std::exchange(first, sum);
    throw_if_stopped(stop);  // a pass takes some milliseconds a million
    for (const std::uint32_t key : keys) other[firsts[d][key >> (11 * d) & (kDigit - 1)]++] = key;
    keys.swap(other);
  }
  for (std::size_t i = 0; i < places.size(); ++i)
    places[i] = std::bit_cast<float>((keys[i] & kSign) != 0 ? keys[i] & ~kSign : ~keys[i]);
}

/// Places along one axis, sorted.
class KdEvents {
 public:
  std::vector<float> begins, ends, flats;  // of parts with extent; of those without

  void gather(const std::vector<KdRef>& refs, int axis, const std::stop_token& stop) {
    begins.clear(), ends.clear(), flats.clear();
    for (std::size_t i = 0; i < refs.size(); ++i) {
      throw_if_stopped(stop, i);
      const float low = refs[i].part.low[axis], high = refs[i].part.high[axis];
      if (low == high) {
        flats.push_back(low);
      } else {
        begins.push_back(low);
        ends.push_back(high);
      }
    }
    for (std::vector<float>* places : {&begins, &ends, &flats}) sort_places(*places, keys_, other_, stop);
  }

 private:
  std::vector<std::uint32_t> keys_, other_;
};

/// Cost of a cell that is parted, as a random line that meets it would pay it.
class KdCost {
 public:
  KdCost(const Box& cell, int axis)
      : low_(cell.low[axis]),
        high_(cell.high[axis]),
        ends_(cell.extent((axis + 1) % 3) * cell.extent((axis + 2) % 3)),
        rim_(cell.extent((axis + 1) % 3) + cell.extent((axis + 2) % 3)),
        area_(ends_ + rim_ * cell.extent(axis)) {}

  double operator()(float place, std::size_t below, std::size_t above) const {
    const double share_below = (ends_ + rim_ * (double{place} - low_)) / area_;
    const double share_above = (ends_ + rim_ * (high_ - double{place})) / area_;
    const double cost = kStepCost + kTestCost * (share_below * static_cast<double>(below) +
                                                 share_above * static_cast<double>(above));
    return below == 0 || above == 0 ? kEmptyBonus * cost : cost;
  }

 private:
  double low_, high_, ends_, rim_, area_;
};

/// Moves past the elements equal to `place`; returns how many there are.
std::size_t pass(const std::vector<float>& places, std::size_t& at, float place) {
  const std::size_t first = at;
  while (at < places.size() && places[at] == place) ++at;
  return at - first;
}

void sweep_axis(const KdEvents& events, const Box& cell, int axis, std::size_t n, KdSplit& best,
                const std::stop_token& stop) {
  const KdCost cost(cell, axis);
  std::size_t begin = 0, end = 0, flat = 0;
  std::size_t below = 0, above = n;  // parts that reach to a side, without those that lie in the plane
  for (std::size_t step = 0;
       begin < events.begins.size() || end < events.ends.size() || flat < events.flats.size(); ++step) {
    throw_if_stopped(stop, step);
    float place = Box::kInfinity;
    if (begin < events.begins.size()) place = std::min(place, events.begins[begin]);
    if (end < events.ends.size()) place = std::min(place, events.ends[end]);
    if (flat < events.flats.size()) place = std::min(place, events.flats[flat]);
    const std::size_t ended = pass(events.ends, end, place), flats = pass(events.flats, flat, place);
    above -= ended + flats;
    if (place > cell.low[axis] && place < cell.high[axis]) {
      const double flat_below = cost(place, below + flats, above),
                   flat_above = cost(place, below, above + flats);
      if (std::min(flat_below, flat_above) < best.cost)
        best = {axis, place, std::min(flat_below, flat_above), flat_below <= flat_above};
    }
    below += pass(events.begins, begin, place) + flats;
  }
}

}  // namespace

KdSplit split_by_sah(const std::vector<KdRef>& refs, const Box& cell, const std::stop_token& stop) {
  KdSplit best;
  KdEvents events;
  for (int axis = 0; axis < 3; ++axis) {
    if (!(cell.extent(axis) > 0)) continue;
    events.gather(refs, axis, stop);
    sweep_axis(events, cell, axis, refs.size(), best, stop);
  }
  return best;
}

}  // namespace tessera::render
