#include "render/shape/implicit/implicit_spans.h"

#include "render/shape/implicit/implicit_search.h"

namespace tessera::render::TESSERA_ISA {

namespace {

ObjectChord chord_of(const ImplicitRecord& surface, const ImplicitLines& lines) {
  const auto load = [](const double(&v)[3][kWidth]) {
    return Point3{Double::load(v[0]), Double::load(v[1]), Double::load(v[2])};
  };
  const Double zero(0.0);
  const Point3 none{zero, zero, zero};
  ObjectChord chord{{load(lines.o), none},
                    {load(lines.d), none},
                    Double(-1e300),
                    Double(1e300),
                    Mask::from_bits(lines.active)};
  clip_to_box(surface, chord);
  if (surface.in_sphere) clip_to_sphere(surface, chord);
  chord.meets &= mask_of(chord.begin < chord.end);
  return chord;
}

template <class F>
void for_each_lane(Mask lanes, F&& f) {
  for (std::uint32_t bits = lanes.bits(); bits != 0; bits &= bits - 1) f(__builtin_ctz(bits));
}

}  // namespace

void add_crossings(const ImplicitRecord& surface, const ImplicitLines& lines, const double (&offset)[kWidth],
                   std::int32_t solid, CsgCrossings* crossings) {
  const ObjectChord whole = chord_of(surface, lines);
  const auto add = [&](Double s, Mask where) {
    alignas(64) double places[kWidth];
    s.store(places);
    for_each_lane(where, [&](int i) { crossings[i].add({offset[i] + places[i], solid, 0}); });
  };
  // Searches are for parameters above 0: those of a chord that begins there.
  ObjectChord chord = whole;
  const Double shift = whole.begin, length = whole.end - whole.begin;
  const Point3 from = whole.at(whole.begin), zero{Double(0.0), Double(0.0), Double(0.0)};
  chord.origin = {from, zero};
  chord.begin = Double(0.0), chord.end = length;

  const auto is_inside = [&](Double s) { return mask_of(value_at(surface, chord.at(s)) < Double(0.0)); };
  Mask inside = chord.meets & is_inside(chord.begin);
  add(shift, inside);
  // More roots than a polynomial has; functions that have more are taken as they are behind the last.
  constexpr int kMostRoots = 256;
  for (int k = 0; k < kMostRoots && any(chord.meets); ++k) {
    const Double root = first_roots(surface, chord, false);
    Mask found = chord.meets & mask_of(root >= chord.begin);
    chord.meets = found;
    if (none(found)) break;
    // On to where f is known to be other than zero.
    Double step = length * Double(0x1p-34), next = root;
    Mask close = found;
    for (int i = 0; i < 34 && any(close); ++i) {
      next = select(double_mask_of(close), root + step, next);
      step = step + step;
      const Point3 p = chord.at(next);
      close &= mask_of(abs(value_at(surface, p)) <= noise_floor(surface, p)) & mask_of(next < chord.end);
    }
    const DoubleMask past = next >= chord.end;
    next = select(past, chord.end, next);
    const Mask now = is_inside(next), changed = found & (now ^ inside);
    add(root + shift, changed);
    inside = inside ^ changed;
    chord.begin = select(double_mask_of(found), next, chord.begin);
    chord.meets &= mask_of(chord.begin < chord.end);
  }
  add(whole.end, inside);
}

}  // namespace tessera::render::TESSERA_ISA
