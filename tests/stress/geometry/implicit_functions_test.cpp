// Implicit surfaces that are no polynomials, against values in long double, sampled densely.
#include "render/shape/implicit/run_program.h"
#include "stress/geometry/implicit_table.h"

namespace tessera::render::TESSERA_ISA::implicit_functions {
namespace {

using expression::Instruction;
using expression::Op;
using Long = long double;

constexpr NamedFunction kFunctions[] = {
    {"gyroid", "sin(3*x)*cos(3*y) + sin(3*y)*cos(3*z) + sin(3*z)*cos(3*x)", 1.5},
    {"cube", "max(abs(x), abs(y), abs(z)) - 0.7", 1.5},
    {"blobs", "exp(-4*((x-0.5)^2+y^2+z^2)) + exp(-4*((x+0.5)^2+y^2+z^2)) - 0.5", 1.5},
    {"torus", "(sqrt(x^2+y^2)-0.7)^2 + z^2 = 0.09", 1.5},
    {"superquadric", "pow(abs(x),2.5) + pow(abs(y),2.5) + pow(abs(z),2.5) - 1", 1.5},
    {"stone", "x^2 + y^2 + z^2 - 1 + 0.3*noise(4*x, 4*y, 4*z)", 1.5},
    {"well", "log(0.2 + x^2 + y^2) + z", 1.5},
    {"lens", "min(max((x-0.5)^2+y^2+z^2-1, (x+0.5)^2+y^2+z^2-1), y^2+z^2-0.01)", 1.4},
    {"pole", "1/(x+0.2) + y + z^2", 1.5},
    {"high", "x^14 + y^14 + z^14 - 1", 1.6}};

/// Whether the sign changes without a root: a pole of 1 / (x + 0.2).
bool jumps(Long a, Long b) { return std::abs(a) > 30 && std::abs(b) > 30; }

Long run_long(const expression::Program& program, Long x, Long y, Long z) {
  Long r[expression::kMaxRegisters] = {x, y, z};
  int last = 0;
  for (const Instruction& i : program.instructions) {
    const Long a = r[i.from[0]], b = r[i.from[1]];
    const auto value = [&]() -> Long {
      switch (i.op) {
        case Op::kX:
        case Op::kY:
        case Op::kZ:
          return a;
        case Op::kConstant:
          return i.value;
        case Op::kAdd:
          return a + b;
        case Op::kSubtract:
          return a - b;
        case Op::kMultiply:
          return a * b;
        case Op::kDivide:
          return a / b;
        case Op::kNegate:
          return -a;
        case Op::kPower:
          return std::pow(a, static_cast<Long>(i.power));
        case Op::kPow:
          return a > 0 ? std::pow(a, b) : 0;
        case Op::kSqrt:
          return std::sqrt(std::max<Long>(a, 0));
        case Op::kSin:
          return std::sin(a);
        case Op::kCos:
          return std::cos(a);
        case Op::kExp:
          return std::exp(a);
        case Op::kLog:
          return std::log(std::max<Long>(a, 1e-300L));
        case Op::kAbs:
          return std::abs(a);
        case Op::kMin:
          return std::min(a, b);
        case Op::kMax:
          return std::max(a, b);
        case Op::kNoise:
          return noise_at({static_cast<double>(a), static_cast<double>(b), static_cast<double>(r[i.from[2]])})
              .value;
      }
      return 0;
    };
    r[i.target] = value();
    last = i.target;
  }
  return r[last];
}

/// f along a ray, in long double.
class LongRay {
 public:
  LongRay(const ImplicitRecord& surface, Point o, Point d) : surface_(surface) {
    Long a = 0, b = 0, c = -Long{surface.radius} * surface.radius;
    for (int i = 0; i < 3; ++i) {
      const float* m = surface.object_from_render.m + 4 * i;
      o_[i] = Long{m[0]} * o.x + Long{m[1]} * o.y + Long{m[2]} * o.z + m[3];
      d_[i] = Long{m[0]} * d.x + Long{m[1]} * d.y + Long{m[2]} * d.z;
      a += d_[i] * d_[i], b += o_[i] * d_[i], c += o_[i] * o_[i];
    }
    const Long square = b * b - a * c;
    if (square <= 0) return;
    begin = std::max<Long>((-b - std::sqrt(square)) / a, 0), end = (-b + std::sqrt(square)) / a;
  }
  Long operator()(Long t) const {
    return run_long(surface_.program, o_[0] + t * d_[0], o_[1] + t * d_[1], o_[2] + t * d_[2]);
  }
  Long begin = 0, end = -1;

 private:
  const ImplicitRecord& surface_;
  Long o_[3], d_[3];
};

/// Whether a hit, or a miss, is what samples allow: f changes its sign, or is next to zero, where the hit is,
/// and nowhere before.
bool is_first(const ImplicitRecord& surface, const RayBatch& batch, int i) {
  const LongRay f(surface, batch.origin(i), batch.direction(i));
  const bool hit = batch.shape[i] >= 0;
  if (f.begin >= f.end) return !hit;
  const Long length = f.end - f.begin, t = batch.t[i], off = 4 * (0x1p-24L * std::abs(t)) + 1e-9L * length;
  if (hit) {
    const Long before = f(t - off), after = f(t + off), here = f(t);
    const Long small = 1e-9L + 2 * std::abs(after - before);
    if (before * after > 0 && std::abs(here) > small) return false;
    if (jumps(before, after)) return false;
  }
  constexpr int kSamples = 3000;
  Long last = f(f.begin);
  for (int k = 1; k <= kSamples; ++k) {
    const Long at = f.begin + length * k / kSamples;
    if (hit && at >= t - off) break;
    const Long value = f(at);
    if (value * last < 0 && !jumps(value, last)) return false;
    last = value;
  }
  return true;
}

class ImplicitFunctions : public testing::TestWithParam<NamedFunction> {};

TEST_P(ImplicitFunctions, AreMetWhereTheyFirstVanish) {
  for (const auto& [size, distance] : {std::pair(1.0, 0.0), std::pair(1e-6, 1e3), std::pair(1e3, 1e5)}) {
    const Point at = unit({0.3, -0.7, 0.65}) * (distance * size);
    const ShapeTable table = implicit_table(GetParam(), ImplicitRoots::kInterval, size, at);
    const TracedTable traced(table, false);
    Numbers random(41);
    RayBatch batch;
    std::int64_t rays = 0, hits = 0, wrong = 0, different = 0;
    const std::int64_t wanted = distance == 0 ? stress_count(1e3, 2e4) : stress_count(512, 5e3);
    for (; rays < wanted; rays += RayBatch::kSize) {
      for (int i = 0; i < RayBatch::kSize; ++i) {
        const Point o = at + random.direction() * (std::max(distance, 3.0) * size);
        batch.aim(i, o, at + random.direction() * (std::cbrt(random()) * GetParam().radius * size));
        batch.distance[i] = static_cast<float>((distance + 20) * 2 * size);
      }
      traced.nearest(batch);
      traced.shadow(batch);
      for (int i = 0; i < RayBatch::kSize; ++i) {
        hits += batch.shape[i] >= 0;
        wrong += !is_first(table.implicits[0], batch, i);
        different += (batch.shape[i] >= 0) != (batch.distance[i] < 0);
      }
    }
    SCOPED_TRACE(testing::Message() << "size " << size << ", distance " << distance << ": " << hits
                                    << " hits of " << rays);
    EXPECT_EQ(wrong, 0);
    EXPECT_EQ(different, 0);
    EXPECT_GT(hits, rays / 10);
  }
}

std::string name_of(const testing::TestParamInfo<NamedFunction>& info) { return info.param.name; }
INSTANTIATE_TEST_SUITE_P(All, ImplicitFunctions, testing::ValuesIn(kFunctions), name_of);

/// Steps that a Lipschitz bound allows meet the same first roots; a bound that is too low is met by holes.
TEST(ImplicitSphereTracing, MeetsFirstRoots) {
  const std::pair<NamedFunction, double> functions[] = {
      {kFunctions[0], 11},    // three partial derivatives of at most 6
      {kFunctions[1], 1.01},  // a coordinate
      {kFunctions[7], 4}};    // twice the distance from a centre, at most 1.9
  for (const auto& [f, lipschitz] : functions) {
    ShapeTable table = implicit_table(f, ImplicitRoots::kSphereTracing, 1, {});
    table.implicits[0].lipschitz = lipschitz;
    const TracedTable traced(table, false);
    Numbers random(42);
    RayBatch batch;
    std::int64_t wrong = 0, hits = 0;
    for (int n = 0; n < 4; ++n) {
      for (int i = 0; i < RayBatch::kSize; ++i)
        batch.aim(i, random.direction() * 3, random.direction() * (std::cbrt(random()) * f.radius));
      traced.nearest(batch);
      for (int i = 0; i < RayBatch::kSize; ++i) {
        hits += batch.shape[i] >= 0;
        wrong += !is_first(table.implicits[0], batch, i);
      }
    }
    EXPECT_EQ(wrong, 0) << f.name;
    EXPECT_GT(hits, 100) << f.name;
  }
}

/// Enclosures hold every value and every slope over random segments, from wide to narrow.
TEST(ImplicitEnclosures, HoldAllValues) {
  Numbers random(43);
  for (const NamedFunction& f : kFunctions) {
    const ShapeTable table = implicit_table(f, ImplicitRoots::kInterval, 1, {});
    const expression::Program& program = table.implicits[0].program;
    std::int64_t outside = 0;
    double narrowest = 1e300;
    for (int n = 0; n < 3000; ++n) {
      const double width = std::pow(10.0, -6 * random());
      double from[3], along[3];
      for (int a = 0; a < 3; ++a) from[a] = 3 * random() - 1.5, along[a] = (2 * random() - 1) * width;
      const auto part = [&](int a) {
        const Double p(from[a]), q(from[a] + along[a]);
        return Dual<Interval, 1>{outward(min(p, q), max(p, q)), {Interval(along[a])}};
      };
      const Dual<Interval, 1> whole = run_program(program, part(0), part(1), part(2));
      alignas(64) double low[kWidth], high[kWidth], slope_low[kWidth], slope_high[kWidth], slope[kWidth];
      whole.value.low.store(low), whole.value.high.store(high);
      whole.d[0].low.store(slope_low), whole.d[0].high.store(slope_high);
      narrowest = std::min(narrowest, high[0] - low[0]);
      for (int k = 0; k <= 4; ++k) {
        const double s = k / 4.0;
        const Long value = run_long(program, from[0] + s * Long{along[0]}, from[1] + s * Long{along[1]},
                                    from[2] + s * Long{along[2]});
        const auto place = [&](int a) {
          return Dual<Double, 1>{Double(from[a] + s * along[a]), {Double(along[a])}};
        };
        const Dual<Double, 1> there = run_program(program, place(0), place(1), place(2));
        there.d[0].store(slope);
        outside += value < low[0] || value > high[0];
        // Slopes at points are rounded themselves.
        const double off = 1e-9 * (std::abs(slope_low[0]) + std::abs(slope_high[0])) + 1e-13;
        if (high[0] < 1e290) outside += slope[0] < slope_low[0] - off || slope[0] > slope_high[0] + off;
      }
    }
    EXPECT_EQ(outside, 0) << f.name;
    EXPECT_LT(narrowest, 1e-3) << f.name;  // and say something
  }
}

/// Gradients by differentiation of the program against differences in long double.
TEST(ImplicitGradients, AreThoseOfDifferences) {
  Numbers random(44);
  for (const NamedFunction& f : kFunctions) {
    const ShapeTable table = implicit_table(f, ImplicitRoots::kInterval, 1, {});
    const expression::Program& program = table.implicits[0].program;
    const bool noisy = std::string_view(f.name) == "stone";  // the noise is in double
    for (int n = 0; n < 500; ++n) {
      const Long p[3] = {Long(2 * random() - 1), Long(2 * random() - 1), Long(2 * random() - 1)};
      const Double zero(0.0), one(1.0);
      using Number = Dual<Double, 3>;
      const Number value = run_program(program, Number{Double(double(p[0])), {one, zero, zero}},
                                       Number{Double(double(p[1])), {zero, one, zero}},
                                       Number{Double(double(p[2])), {zero, zero, one}});
      for (int a = 0; a < 3; ++a) {
        const Long h = noisy ? 1e-5L : 1e-6L;
        Long ahead[3] = {p[0], p[1], p[2]}, behind[3] = {p[0], p[1], p[2]};
        ahead[a] += h, behind[a] -= h;
        const Long there = run_long(program, ahead[0], ahead[1], ahead[2]),
                   here = run_long(program, p[0], p[1], p[2]),
                   back = run_long(program, behind[0], behind[1], behind[2]);
        // Not across a crease, where differences to both sides disagree.
        if (std::abs((there - here) - (here - back)) > 1e-2L * h) continue;
        alignas(64) double d[kWidth];
        value.d[a].store(d);
        const double expected = static_cast<double>((there - back) / (2 * h));
        // Differences are off by h^2 times a third derivative, which is below 1e4 where it is no pole.
        ASSERT_NEAR(d[0], expected, (noisy ? 1e-5 : 1e-7) * (1 + expected * expected)) << f.name;
      }
    }
  }
}

}  // namespace
}  // namespace tessera::render::TESSERA_ISA::implicit_functions
