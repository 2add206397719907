// A function of an implicit surface along 16 lines.
#pragma once

#include "render/shape/implicit/dual.h"
#include "render/shape/implicit/interval.h"
#include "render/shape/implicit/object_ray.h"
#include "render/shape/implicit/run_program.h"

namespace tessera::render::TESSERA_ISA {

/// The function along chords, whose parts are numbered from 0 to 1.
class ChordFunction {
 public:
  ChordFunction(const ImplicitRecord& surface, const ObjectChord& chord)
      : program_(surface.program), from_(chord.at(chord.begin)) {
    const Double length = chord.end - chord.begin;
    const Point3& d = chord.direction.value;
    along_ = {d.x * length, d.y * length, d.z * length};
  }

  /// The function along one of the chords, in all lanes.
  ChordFunction of_lane(int i) const {
    const auto all = [i](const Point3& p) {
      alignas(64) double x[kWidth], y[kWidth], z[kWidth];
      p.x.store(x), p.y.store(y), p.z.store(z);
      return Point3{Double(x[i]), Double(y[i]), Double(z[i])};
    };
    return ChordFunction(program_, all(from_), all(along_));
  }

  /// The chords' beginnings, and the ways from there to their ends.
  const Point3& from() const { return from_; }
  const Point3& along() const { return along_; }

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
  ChordFunction(const expression::Program& program, const Point3& from, const Point3& along)
      : program_(program), from_(from), along_(along) {}

  static Interval part(Double from, Double along, Double begin, Double end) {
    const Double a = fma(begin, along, from), b = fma(end, along, from);
    return outward(min(a, b), max(a, b));
  }

  const expression::Program& program_;
  Point3 from_, along_;
};

}  // namespace tessera::render::TESSERA_ISA
