#include "render/shape/implicit/function_roots.h"

#include <algorithm>

namespace tessera::render::TESSERA_ISA {

namespace {

/// The function along the chords, whose parts are numbered from 0 to 1.
class ChordFunction {
 public:
  ChordFunction(const ImplicitRecord& surface, const ObjectChord& chord)
      : program_(surface.program), from_(chord.at(chord.begin)) {
    const Double length = chord.end - chord.begin;
    const Point3& d = chord.direction.value;
    along_ = {d.x * length, d.y * length, d.z * length};
  }

  Double operator()(Double s) const {
    return run_program(program_, fma(s, along_.x, from_.x), fma(s, along_.y, from_.y),
                       fma(s, along_.z, from_.z));
  }
  Dual<Double, 1> with_slope(Double s) const {
    const auto place = [&](Double from, Double along) {
      return Dual<Double, 1>{fma(s, along, from), {along}};
    };
    return run_program(program_, place(from_.x, along_.x), place(from_.y, along_.y),
                       place(from_.z, along_.z));
  }
  /// Encloses f at `s`, roundings included.
  Interval enclosed(Double s) const {
    return run_program(program_, part(from_.x, along_.x, s, s), part(from_.y, along_.y, s, s),
                       part(from_.z, along_.z, s, s));
  }
  /// Encloses f and its slope over [begin, end].
  Dual<Interval, 1> over(Double begin, Double end) const {
    const auto place = [&](Double from, Double along) {
      return Dual<Interval, 1>{part(from, along, begin, end), {Interval(along, along)}};
    };
    return run_program(program_, place(from_.x, along_.x), place(from_.y, along_.y),
                       place(from_.z, along_.z));
  }

 private:
  static Interval part(Double from, Double along, Double begin, Double end) {
    const Double a = fma(begin, along, from), b = fma(end, along, from);
    return outward(min(a, b), max(a, b));
  }

  const expression::Program& program_;
  Point3 from_, along_;
};

/// Where f is zero in [low, high], at whose ends the signs differ.
Double refine(const ChordFunction& f, Double low, Double high, Mask active) {
  const Double at_low = f(low);
  Double s = (low + high) * Double(0.5);
  constexpr int kMostSteps = 60;
  for (int i = 0; i < kMostSteps; ++i) {
    const Dual<Double, 1> there = f.with_slope(s);
    const DoubleMask before = at_low * there.value <= Double(0.0);
    high = select(before, s, high);
    low = select(before, low, s);
    const Double newton = s - there.value / there.d[0];
    const DoubleMask inside = (newton > low) & (newton < high);
    const Double next = select(inside, newton, (low + high) * Double(0.5));
    const Mask moves = active & mask_of(abs(next - s) > Double(0x1p-48));
    s = select(there.value == Double(0.0), s, next);
    if (none(moves)) break;
  }
  return s;
}

Mask surely_positive(const Interval& a) { return mask_of(a.low > Double(0.0)); }
Mask surely_negative(const Interval& a) { return mask_of(a.high < Double(0.0)); }
Mask is_bounded(const Interval& a) { return mask_of(magnitude(a).high < Double(1e290)); }

/// From parts of the chords to ray parameters.
Double ray_parameter(const ObjectChord& chord, Double s, Mask found) {
  return select(double_mask_of(found), fma(s, chord.end - chord.begin, chord.begin), Double(-1.0));
}

}  // namespace

Double first_roots_by_enclosure(const ImplicitRecord& surface, const ObjectChord& chord) {
  constexpr double kNarrowest = 0x1p-34;
  constexpr int kMostSteps = 4096;
  const ChordFunction f(surface, chord);
  Mask active = chord.meets, touched = Mask::none(), bracketed = Mask::none();
  Double s(0.0), width(1.0);
  for (int i = 0; any(active) && i < kMostSteps; ++i) {
    const Double end = s + width;
    const Dual<Interval, 1> part = f.over(s, end);
    Mask empty = surely_positive(part.value) | surely_negative(part.value);
    if (any(and_not(active, empty))) {
      const Interval at_begin = f.enclosed(s), at_end = f.enclosed(end);
      // From either end, f moves no faster than the enclosed slope.
      const Interval way = part.d[0] * Interval(Double(0.0), width);
      const Interval from_begin = at_begin + way, from_end = at_end - way;
      empty |= surely_positive(from_begin) | surely_negative(from_begin) | surely_positive(from_end) |
               surely_negative(from_end);
      const Mask monotone = surely_positive(part.d[0]) | surely_negative(part.d[0]);
      const Mask rises = surely_negative(at_begin) & surely_positive(at_end),
                 falls = surely_positive(at_begin) & surely_negative(at_end);
      const Mask same = (surely_positive(at_begin) & surely_positive(at_end)) |
                        (surely_negative(at_begin) & surely_negative(at_end));
      empty |= monotone & same;
      const Mask open = and_not(active, empty);
      const Mask narrow = mask_of(width <= Double(kNarrowest));
      const Mask one = open & is_bounded(part.value) & (rises | falls) & (monotone | narrow);
      const Mask touch = and_not(open & narrow & is_bounded(part.value), one);
      // At a pole the sign changes without a root.
      empty |= and_not(open & narrow, is_bounded(part.value));
      bracketed |= one, touched |= touch;
      active = and_not(active, one | touch);
    }
    // Forward and, where that keeps parts in line, wider; or half of the part.
    const DoubleMask forward = double_mask_of(active & empty), halve = double_mask_of(and_not(active, empty));
    s = select(forward, end, s);
    const Double twice = width + width;
    const DoubleMask in_line = floor(s / twice) * twice == s;
    width = select(halve, width * Double(0.5), select(forward & in_line, min(twice, Double(1.0)), width));
    active = and_not(active, mask_of(forward & (s >= Double(1.0))));
  }
  touched |= active;  // the steps are used up
  if (any(bracketed)) s = select(double_mask_of(bracketed), refine(f, s, s + width, bracketed), s);
  return ray_parameter(chord, s, touched | bracketed);
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
  if (any(between)) s = select(double_mask_of(between), refine(f, before, s, between), s);
  const Double root = ray_parameter(chord, s, found | between);
  if (none(active)) return root;
  // A ray along the surface, whose steps are as short as it is close.
  ObjectChord rest = chord;
  rest.begin = ray_parameter(chord, s, active);
  rest.meets = active;
  return select(double_mask_of(active), first_roots_by_enclosure(surface, rest), root);
}

}  // namespace tessera::render::TESSERA_ISA
