#include "render/shape/implicit/function_roots.h"

#include <algorithm>
#include <utility>

#include "render/shape/implicit/cell_walk.h"
#include "render/shape/implicit/refine_bracket.h"

namespace tessera::render::TESSERA_ISA {

namespace {

Mask surely_positive(const Interval& a) { return mask_of(a.low > Double(0.0)); }
Mask surely_negative(const Interval& a) { return mask_of(a.high < Double(0.0)); }
Mask is_bounded(const Interval& a) { return mask_of(magnitude(a).high < Double(1e290)); }

/// From parts of the chords to ray parameters.
Double ray_parameter(const ObjectChord& chord, Double s, Mask found) {
  return select(double_mask_of(found), fma(s, chord.end - chord.begin, chord.begin), Double(-1.0));
}

}  // namespace

namespace {

/// The answer of an enclosure about parts of chords.
struct PartAnswer {
  Mask empty;    // no root
  Mask one;      // exactly one, between signs that differ
  Mask touched;  // nothing at the narrowest: the surface is touched, or is beyond what doubles tell apart
};

/// Parts of which nothing is told are halved until they are so narrow, in parts of the chord.
constexpr double kNarrowest = 0x1p-34;

PartAnswer look_at(const ChordFunction& f, Double begin, Double end, Mask active) {
  const Dual<Interval, 1> part = f.over(begin, end);
  PartAnswer answer{surely_positive(part.value) | surely_negative(part.value), Mask::none(), Mask::none()};
  if (none(and_not(active, answer.empty))) return answer;
  const Interval at_begin = f.enclosed(begin), at_end = f.enclosed(end);
  // From either end, f moves no faster than the enclosed slope.
  const Double width = end - begin;
  const Interval way = part.d[0] * Interval(Double(0.0), width);
  const Interval from_begin = at_begin + way, from_end = at_end - way;
  answer.empty |= surely_positive(from_begin) | surely_negative(from_begin) | surely_positive(from_end) |
                  surely_negative(from_end);
  const Mask monotone = surely_positive(part.d[0]) | surely_negative(part.d[0]);
  const Mask rises = surely_negative(at_begin) & surely_positive(at_end),
             falls = surely_positive(at_begin) & surely_negative(at_end);
  const Mask same = (surely_positive(at_begin) & surely_positive(at_end)) |
                    (surely_negative(at_begin) & surely_negative(at_end));
  answer.empty |= monotone & same;
  const Mask open = and_not(active, answer.empty), bounded = is_bounded(part.value);
  const Mask narrow = mask_of(width <= Double(kNarrowest));
  answer.one = open & bounded & (rises | falls) & (monotone | narrow);
  answer.touched = and_not(open & narrow & bounded, answer.one);
  // At a pole the sign changes without a root.
  answer.empty |= and_not(open & narrow, bounded);
  return answer;
}

}  // namespace

namespace {

using Part = std::pair<double, double>;

/// Looks at the first sixteen of `parts`, or all. Lanes beyond have the last one.
PartAnswer look_at_first(const ChordFunction& f, const std::vector<Part>& parts, std::size_t n) {
  alignas(64) double begin[kWidth], end[kWidth];
  for (std::size_t i = 0; i < kWidth; ++i)
    begin[i] = parts[std::min(i, n - 1)].first, end[i] = parts[std::min(i, n - 1)].second;
  return look_at(f, Double::load(begin), Double::load(end), Mask::first(static_cast<int>(n)));
}

/// The place of the first root in the chord of one lane, or a negative number: sixteen of its parts are
/// looked at together, in the time that one takes.
double first_root_of_lane(const ImplicitRecord& surface, const ChordFunction& all, int lane, bool any_root) {
  constexpr int kMostSteps = 1024;
  const ChordFunction f = all.of_lane(lane);
  CellWalk cells(surface, f);
  Double base(0.0), length(1.0);
  // Parts in their order; behind them are those that `cells` has still to give.
  static thread_local std::vector<Part> parts, next;
  parts.clear();
  bool more = true;
  const auto fill = [&] {
    while (more && parts.size() < kWidth) {
      more = any(cells.next(Mask::first(1), base, length));
      alignas(64) double begin[kWidth], end[kWidth];
      base.store(begin), (base + length).store(end);
      const int pieces = more && surface.cells == 0 ? kWidth : 1;
      for (int i = 0; more && i < pieces; ++i) {
        const double width = (end[0] - begin[0]) / pieces;
        parts.emplace_back(begin[0] + i * width, i + 1 < pieces ? begin[0] + (i + 1) * width : end[0]);
      }
    }
  };
  for (int step = 0; fill(), !parts.empty(); ++step) {
    const std::size_t n = std::min<std::size_t>(parts.size(), kWidth);
    const PartAnswer answer = look_at_first(f, parts, n);
    const std::uint32_t one = answer.one.bits(),
                        touched = answer.touched.bits() | (step >= kMostSteps ? ~0u : 0u);
    const std::uint32_t some = ~answer.empty.bits() & ((1u << n) - 1u);
    if (some != 0) {
      const auto first = static_cast<std::size_t>(__builtin_ctz(some));
      if ((one >> first & 1) != 0) {
        if (any_root) return parts[first].first;
        alignas(64) double root[kWidth];
        refine_bracket(f, Double(parts[first].first), Double(parts[first].second), Mask::first(1))
            .store(root);
        return root[0];
      }
      if ((touched >> first & 1) != 0) return parts[first].first;
    }
    // Those that may have a root, cut so that sixteen are looked at again; behind a certain one is none
    // first.
    const int pieces = std::max(2, kWidth / std::max(1, __builtin_popcount(some & ~one)));
    bool ends = false;
    next.clear();
    for (std::size_t i = 0; i < n && !ends; ++i) {
      if ((some >> i & 1) == 0) continue;
      ends = ((one | touched) >> i & 1) != 0;
      const auto [begin, end] = parts[i];
      const double width = (end - begin) / pieces;
      for (int k = 0; k < (ends ? 1 : pieces); ++k)
        next.emplace_back(begin + k * width, ends || k + 1 == pieces ? end : begin + (k + 1) * width);
    }
    if (!ends) next.insert(next.end(), parts.begin() + static_cast<std::ptrdiff_t>(n), parts.end());
    more = more && !ends;
    parts.swap(next);
  }
  return -1;
}

}  // namespace

Double first_roots_by_enclosure(const ImplicitRecord& surface, const ObjectChord& chord, bool any_root) {
  constexpr int kMostSteps = 4096, kFewLanes = 3;
  const ChordFunction f(surface, chord);
  if (const std::uint32_t lanes = chord.meets.bits(); __builtin_popcount(lanes) <= kFewLanes) {
    alignas(64) double places[kWidth] = {};
    std::uint32_t found = 0;
    for (std::uint32_t bits = lanes; bits != 0; bits &= bits - 1) {
      const int i = __builtin_ctz(bits);
      const double place = first_root_of_lane(surface, f, i, any_root);
      if (place >= 0) places[i] = place, found |= 1u << i;
    }
    return ray_parameter(chord, Double::load(places), Mask::from_bits(found));
  }
  CellWalk cells(surface, f);
  // A lane looks at [base + s length, base + (s + width) length] of its chord.
  Double base(0.0), length(1.0), s(0.0), width(1.0);
  Mask touched = Mask::none(), bracketed = Mask::none();
  Mask active = cells.next(chord.meets, base, length);
  for (int i = 0; any(active) && i < kMostSteps; ++i) {
    const Double next = s + width;
    const PartAnswer part = look_at(f, fma(s, length, base), fma(next, length, base), active);
    bracketed |= active & part.one, touched |= active & part.touched;
    active = and_not(active, part.one | part.touched);
    // Forward and, where that keeps parts in line, wider; or half of the part.
    const DoubleMask forward = double_mask_of(active & part.empty),
                     halve = double_mask_of(and_not(active, part.empty));
    s = select(forward, next, s);
    const Double twice = width + width;
    const DoubleMask in_line = floor(s / twice) * twice == s;
    width = select(halve, width * Double(0.5), select(forward & in_line, min(twice, Double(1.0)), width));
    const Mask ended = mask_of(forward & (s >= Double(1.0)));
    if (none(ended)) continue;
    active = and_not(active, ended) | cells.next(ended, base, length);
    s = select(double_mask_of(ended), Double(0.0), s);
    width = select(double_mask_of(ended), Double(1.0), width);
  }
  touched |= active;  // the steps are used up
  Double root = fma(s, length, base);
  if (any(bracketed) && !any_root)
    root = select(double_mask_of(bracketed), refine_bracket(f, root, fma(s + width, length, base), bracketed),
                  root);
  return ray_parameter(chord, root, touched | bracketed);
}

void all_roots_by_enclosure(const ImplicitRecord& surface, const ObjectChord& chord,
                            std::vector<double>& found) {
  if (none(chord.meets)) return;
  constexpr int kFirstParts = 16;
  constexpr std::size_t kMostParts = std::size_t{1} << 16;
  const ChordFunction f(surface, chord);
  std::vector<Part> open, one, touched;
  if (surface.cells == 0) {
    for (int i = 0; i < kFirstParts; ++i)
      open.emplace_back(static_cast<double>(i) / kFirstParts, (i + 1.0) / kFirstParts);
  } else {
    CellWalk cells(surface, f);
    Double base(0.0), length(1.0);
    alignas(64) double begin[kWidth], end[kWidth];
    while (any(cells.next(Mask::first(1), base, length))) {
      base.store(begin), (base + length).store(end);
      open.emplace_back(begin[0], end[0]);
    }
  }
  /// Calls go(begins, ends, active) for sixteen of `parts` at a time.
  const auto by_sixteen = [](std::vector<Part>& parts, auto&& go) {
    const std::size_t n = std::min<std::size_t>(parts.size(), kWidth);
    alignas(64) double begin[kWidth], end[kWidth];
    const std::size_t first = parts.size() - n;
    for (std::size_t i = 0; i < kWidth; ++i) {
      const Part& part = parts[first + std::min(i, n - 1)];
      begin[i] = part.first, end[i] = part.second;
    }
    parts.resize(first);
    go(Double::load(begin), Double::load(end), Mask::first(static_cast<int>(n)), begin, end);
  };
  const auto each = [](Mask lanes, auto&& go) {
    for (std::uint32_t bits = lanes.bits(); bits != 0; bits &= bits - 1) go(__builtin_ctz(bits));
  };
  for (std::size_t looked = 0; !open.empty() && looked < kMostParts; looked += kWidth) {
    by_sixteen(open, [&](Double begin, Double end, Mask active, const double* from, const double* to) {
      const PartAnswer part = look_at(f, begin, end, active);
      each(part.one & active, [&](int i) { one.emplace_back(from[i], to[i]); });
      each(part.touched & active, [&](int i) { touched.emplace_back(from[i], to[i]); });
      each(and_not(active, part.empty | part.one | part.touched), [&](int i) {
        const double middle = from[i] + (to[i] - from[i]) / 2;
        open.emplace_back(from[i], middle);
        open.emplace_back(middle, to[i]);
      });
    });
  }
  alignas(64) double roots[kWidth];
  while (!one.empty()) {
    by_sixteen(one, [&](Double begin, Double end, Mask active, const double*, const double*) {
      ray_parameter(chord, refine_bracket(f, begin, end, active), active).store(roots);
      each(active, [&](int i) { found.push_back(roots[i]); });
    });
  }
  // Neighbours that were touched are one place: whether the surface is crossed there its two ends tell.
  std::ranges::sort(touched);
  for (std::size_t i = 0; i < touched.size();) {
    Part place = touched[i];
    for (++i; i < touched.size() && touched[i].first <= place.second + kNarrowest; ++i)
      place.second = std::max(place.second, touched[i].second);
    const double off = 4 * kNarrowest;
    alignas(64) double ends[kWidth] = {std::max(place.first - off, 0.0), std::min(place.second + off, 1.0)};
    f(Double::load(ends)).store(ends);
    ray_parameter(chord, Double((place.first + place.second) / 2), Mask::first(1)).store(roots);
    found.insert(found.end(), (ends[0] < 0) != (ends[1] < 0) ? 1 : 2, roots[0]);
  }
}

Double roots_between_signs(const ImplicitRecord& surface, const ObjectChord& chord) {
  const ChordFunction f(surface, chord);
  const Mask differ = chord.meets & mask_of(f(Double(0.0)) * f(Double(1.0)) < Double(0.0));
  if (none(differ)) return Double(-1.0);
  // The chord is as long as the rounding of a float: doubles tell no more than that apart.
  return ray_parameter(chord, refine_bracket(f, Double(0.0), Double(1.0), differ, 0x1p-26), differ);
}

double sphere_tracing_tolerance(const ImplicitRecord& surface) {
  double size = 0;
  for (int a = 0; a < 3; ++a) size = std::max(size, double{surface.high[a]} - double{surface.low[a]});
  return surface.lipschitz * size * 0x1p-34;
}

Double first_roots_by_sphere_tracing(const ImplicitRecord& surface, const ObjectChord& chord) {
  constexpr int kMostSteps = 512;
  const ChordFunction f(surface, chord);
  const Double length = (chord.end - chord.begin) * length_of(chord.direction.value);
  const Double per_value = Double(1.0) / (length * Double(surface.lipschitz));
  const Double tolerance(sphere_tracing_tolerance(surface));
  Mask active = chord.meets, found = Mask::none(), crossed = Mask::none();
  Double s(0.0), before(0.0);
  Double value = f(s);
  const DoubleMask positive = value > Double(0.0);
  for (int i = 0; any(active) && i < kMostSteps; ++i) {
    // A bound that was too low shows when the sign changes.
    const DoubleMask turned = (value * select(positive, Double(1.0), Double(-1.0))) < Double(0.0);
    crossed |= active & mask_of(turned);
    found |= active & mask_of(abs(value) <= tolerance);
    active = and_not(active, found | crossed);
    const DoubleMask moves = double_mask_of(active);
    before = select(moves, s, before);
    s = select(moves, fma(abs(value), per_value, s), s);
    active = and_not(active, mask_of(s > Double(1.0)));
    value = f(s);
  }
  const Mask between = and_not(crossed, found);
  if (any(between)) s = select(double_mask_of(between), refine_bracket(f, before, s, between), s);
  const Double root = ray_parameter(chord, s, found | between);
  if (none(active)) return root;
  // A ray along the surface, whose steps are as short as it is close.
  ObjectChord rest = chord;
  rest.begin = ray_parameter(chord, s, active);
  rest.meets = active;
  return select(double_mask_of(active), first_roots_by_enclosure(surface, rest, false), root);
}

}  // namespace tessera::render::TESSERA_ISA
