#include <cmath>

#include "render/shape/double_ray.h"
#include "render/shape/round_form.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// A polynomial of degree at most 4, its coefficients from the constant on.
struct Quartic {
  Double c[5];

  TESSERA_INLINE Double operator()(Double s) const {
    return (((c[4] * s + c[3]) * s + c[2]) * s + c[1]) * s + c[0];
  }
  TESSERA_INLINE Quartic derivative() const {
    return {{c[1], 2.0 * c[2], 3.0 * c[3], 4.0 * c[4], splat(0.0)}};
  }
};

/// Where `f` changes its sign in [low, high], over which it is monotonic: Newton's method, and halving where
/// that leaves the bracket. `high` where it does not change.
TESSERA_INLINE Double root_between(const Quartic& f, const Quartic& slope, Double low, Double high,
                                   DoubleMask& changes) {
  const DoubleMask below = f(low) < 0.0;
  changes = (below ^ (f(high) < 0.0)) & (low <= high);
  const Double end = high;
  if (!any_of(changes)) return end;
  Double s = 0.5 * (low + high);
  constexpr int kMostSteps = 100;  // halving alone needs 53
  // A lane that is done stays as it is: its root does not depend on the rays beside it.
  DoubleMask moves = changes;
  for (int i = 0; i < kMostSteps && any_of(moves); ++i) {
    const Double value = f(s);
    const DoubleMask before = below ^ (value < 0.0);
    high = before ? s : high;
    low = before ? low : s;
    const Double newton = s - value / slope(s);
    const Double next = (newton >= low) & (newton <= high) ? newton : 0.5 * (low + high);
    const Double step = next - s;
    s = moves ? next : s;
    moves &= (step > 1e-15) | (step < -1e-15);
  }
  return changes ? s : end;
}

/// The place in each piece where `f` changes its sign, given the ends of pieces over which it is monotonic;
/// the upper end of those over which it does not.
template <int kPieces>
TESSERA_INLINE void roots_of_pieces(const Quartic& f, const Double (&ends)[kPieces + 1],
                                    Double (&found)[kPieces], DoubleMask (&changes)[kPieces]) {
  const Quartic slope = f.derivative();
  for (int i = 0; i < kPieces; ++i) found[i] = root_between(f, slope, ends[i], ends[i + 1], changes[i]);
}

constexpr RoundForm kForm{
    .is_solid = [](const QuadricRecord&) { return true; },
    .contains =
        [](const QuadricRecord& q, const double (&p)[3]) {
          return std::hypot(std::hypot(p[0], p[1]) - 1, p[2]) < double{q.inner_radius};
        },
    .support =
        [](const QuadricRecord& q, const double (&a)[3]) {
          return std::hypot(a[0], a[1]) +
                 double{q.inner_radius} * std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
        },
    .profile = [](const QuadricRecord& q) -> std::vector<ProfilePiece> {
      const double tube = q.inner_radius;
      return {{.ax = 1, .az = 0, .bx = 0, .bz = 0, .radius = tube, .z_low = -tube, .z_high = tube}};
    }};

/// A tube about the circle of radius 1 in z = 0.
///
/// The quartic of the distance to the tube is split where its derivative changes its sign, and that cubic in
/// turn, so that each piece is monotonic: a root cannot be missed or found twice.
class TorusShape final : public CrossedShape {
 public:
  const RoundForm* round_form() const override { return &kForm; }
  ShapeBounds bounds(const ShapeTable& table, const ShapeRecord& shape, std::int32_t) const override {
    const QuadricRecord& q = table.quadrics[static_cast<std::size_t>(shape.quadric)];
    return placed_bounds(q.render_from_object, {0, 0, 0},
                         {1 + q.inner_radius, 1 + q.inner_radius, q.inner_radius});
  }
  int spans(const ShapeTable& table, const ShapeRecord& shape, const DoubleRay& ray,
            SolidSpans& found) const override {
    Crossings roots;
    cross(table, table.quadrics[static_cast<std::size_t>(shape.quadric)], ray, roots);
    Double* const s = roots.s;
    const auto order = [s](int i, int k) {
      const Double first = lower(s[i], s[k]);
      s[k] = upper(s[i], s[k]);
      s[i] = first;
    };
    order(0, 1), order(2, 3), order(0, 2), order(1, 3), order(1, 2);
    for (int k = 0; k < 2; ++k) {
      const DoubleMask both = s[2 * k + 1] < kNoRoot;
      found.enter[k] = both ? s[2 * k] : splat(kNoRoot);
      found.leave[k] = s[2 * k + 1];
    }
    return 2;
  }

 protected:
  int cross(const ShapeTable&, const QuadricRecord& q, const DoubleRay& ray,
            Crossings& found) const override {
    // In units of length along the ray.
    const double tube = q.inner_radius;
    Double d[3], length = square_root(ray.d[0] * ray.d[0] + ray.d[1] * ray.d[1] + ray.d[2] * ray.d[2]);
    for (int i = 0; i < 3; ++i) d[i] = ray.d[i] / length;
    const Double *const o = ray.o, m = o[0] * o[0] + o[1] * o[1] + o[2] * o[2],
                        n = o[0] * d[0] + o[1] * d[1] + o[2] * d[2], g = m + (1 - tube * tube);
    // (|p|^2 + 1 - tube^2)^2 = 4 (x^2 + y^2)
    const Quartic f{{g * g - 4.0 * (o[0] * o[0] + o[1] * o[1]),
                     4.0 * n * g - 8.0 * (o[0] * d[0] + o[1] * d[1]),
                     4.0 * n * n + 2.0 * g - 4.0 * (d[0] * d[0] + d[1] * d[1]), 4.0 * n, splat(1.0)}};
    // All roots lie within a sphere about the torus; a little beyond it they are outside for certain.
    const double reach = (1 + tube) * 1.001;
    const Double left = reach * reach - m, end = square_root(upper(left, splat(0.0)));
    const DoubleMask meets = left > 0.0;
    for (int k = 0; k < 4; ++k) found.s[k] = splat(kNoRoot);
    if (!any_of(meets)) return 4;

    const Quartic slope = f.derivative(), bend = slope.derivative();
    // bend is 12 s^2 + ...: its roots, or twice its lowest place.
    const Double lowest = bend.c[1] / (-2.0 * bend.c[2]);
    const Double apart = lowest * lowest - bend.c[0] / bend.c[2];
    const Double half = square_root(upper(apart, splat(0.0)));
    const auto within = [&](Double s) { return lower(upper(s, -end), end); };
    const Double turns[4] = {-end, within(lowest - half), within(lowest + half), end};
    Double extrema[3];
    DoubleMask unused[3], changes[4];
    roots_of_pieces<3>(slope, turns, extrema, unused);
    const Double ends[5] = {-end, extrema[0], extrema[1], extrema[2], end};
    Double roots[4];
    roots_of_pieces<4>(f, ends, roots, changes);
    for (int k = 0; k < 4; ++k) found.s[k] = meets & changes[k] ? roots[k] / length : found.s[k];
    return 4;
  }
  ObjectPoint point_in_object(const ShapeTable&, const QuadricRecord& q, Vec3 p) const override {
    const float tube = q.inner_radius;
    const Float rho = max(sqrt(sqr(p.x) + sqr(p.y)), 1e-30f), inverse = 1.0f / rho;
    const Float x = p.x * inverse, y = p.y * inverse, zero(0.0f);
    // From the circle to the point, in the half-plane through the axis.
    const Float out = rho - 1.0f, scale = 1.0f / max(sqrt(sqr(out) + sqr(p.z)), 1e-30f);
    const Float cosine = out * scale, sine = p.z * scale, radius = fma(cosine, Float(tube), Float(1.0f));
    ObjectPoint o;
    o.p = {x * radius, y * radius, sine * tube};
    o.n = {x * cosine, y * cosine, sine};
    const Float around = azimuth({cosine, sine, zero});
    o.uv = {azimuth(p) * (1 / (2 * kPi)), around * (1 / (2 * kPi))};
    o.dpdu = Vec3{-o.p.y, o.p.x, zero} * Float(2 * kPi);
    o.dpdv = Vec3{-x * sine, -y * sine, cosine} * Float(2 * kPi * tube);
    o.extent = Float(1 + tube);
    return o;
  }
};

}  // namespace

const ModelOf<TorusShape> torus(ShapeKind::kTorus);

}  // namespace tessera::render::TESSERA_ISA
