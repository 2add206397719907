#include <cmath>

#include "render/core/affine.h"
#include "render/shape/csg/csg_mesh.h"
#include "render/shape/double_ray.h"
#include "render/shape/implicit/implicit_spans.h"

namespace tessera::render::TESSERA_ISA {

namespace {

const CsgRecord& record_of(const ShapeTable& table, const ShapeRecord& shape) {
  return table.csgs[static_cast<std::size_t>(shape.quadric)];
}

/// Lanes of a part of 16 rays.
constexpr std::uint32_t kPartLanes = (1u << kDoubleWidth) - 1;

/// Adds the spans of some rays in one of the solids.
void add_spans(const ShapeTable& table, const CsgRecord& csg, std::int32_t index, const DoubleRay& ray,
               std::uint32_t lanes, CsgCrossings* crossings) {
  const CsgSolid& solid = csg.solids[static_cast<std::size_t>(index)];
  if (solid.mesh >= 0) {
    for (std::uint32_t bits = lanes; bits != 0; bits &= bits - 1) {
      const int i = __builtin_ctz(bits);
      add_crossings(csg.meshes[static_cast<std::size_t>(solid.mesh)], {ray.o[0][i], ray.o[1][i], ray.o[2][i]},
                    {ray.d[0][i], ray.d[1][i], ray.d[2][i]}, index, crossings[i]);
    }
    return;
  }
  const ShapeRecord& shape = table.shapes[static_cast<std::size_t>(solid.shape)];
  const DoubleRay own(solid.object_from_unit, ray);
  if (shape.kind == ShapeKind::kImplicit) {
    ImplicitLines lines;
    alignas(64) double offset[kWidth] = {};
    lines.active = lanes;
    for (int i = 0; i < kDoubleWidth; ++i) {
      for (int a = 0; a < 3; ++a) lines.o[a][i] = own.o[a][i], lines.d[a][i] = own.d[a][i];
      offset[i] = own.t[i];
    }
    add_crossings(table.implicits[static_cast<std::size_t>(shape.quadric)], lines, offset, index, crossings);
    return;
  }
  SolidSpans spans;
  const int count = analytic_shape(shape.kind)->spans(table, shape, own, spans);
  for (int k = 0; k < count; ++k) {
    const Double enter = own.t + spans.enter[k], leave = own.t + spans.leave[k];
    for (std::uint32_t bits = lanes; bits != 0; bits &= bits - 1) {
      const int i = __builtin_ctz(bits);
      if (enter[i] < leave[i]) crossings[i].add_span(enter[i], leave[i], index);
    }
  }
}

/// The lanes whose rays meet a node's box between their origins and `t_far`. All that is within a box that
/// ends before, or begins behind, leaves no trace there: a solid that is entered is left again.
class BoxTest {
 public:
  BoxTest(const DoubleRay& ray, const float* t_far) : BoxTest(ray) {
    begin_ = -ray.t;
    for (int i = 0; i < kDoubleWidth; ++i) end_[i] = static_cast<double>(t_far[i]) - ray.t[i];
  }
  /// Tests whole lines.
  explicit BoxTest(const DoubleRay& ray) : begin_(splat(-kNoRoot)), end_(splat(kNoRoot)) {
    for (int i = 0; i < 3; ++i) {
      o_[i] = ray.o[i];
      const DoubleMask moves = (ray.d[i] > 1e-300) | (ray.d[i] < -1e-300);
      inverse_[i] = 1.0 / (moves ? ray.d[i] : splat(1e-300));
    }
  }
  std::uint32_t operator()(const CsgNode& node) const {
    Double enter = begin_, leave = end_;
    for (int i = 0; i < 3; ++i) {
      const Double a = (node.low[i] - o_[i]) * inverse_[i], b = (node.high[i] - o_[i]) * inverse_[i];
      enter = upper(enter, lower(a, b)), leave = lower(leave, upper(a, b));
    }
    const DoubleMask meets = enter <= leave;
    std::uint32_t lanes = 0;
    for (int i = 0; i < kDoubleWidth; ++i) lanes |= static_cast<std::uint32_t>(meets[i] & 1) << i;
    return lanes;
  }

 private:
  Double o_[3], inverse_[3], begin_, end_;
};

/// Adds the crossings of some rays with all solids that matter to them; returns those that meet the whole.
std::uint32_t add_all_spans(const ShapeTable& table, const CsgRecord& csg, const DoubleRay& ray,
                            const BoxTest& meets, std::uint32_t lanes, CsgCrossings* crossings) {
  for (std::int32_t i = 0; i < static_cast<std::int32_t>(csg.nodes.size());) {
    const CsgNode& node = csg.nodes[static_cast<std::size_t>(i)];
    const std::uint32_t there = lanes & meets(node);
    if (i == 0) lanes = there;
    if (there != 0 && node.solid >= 0) add_spans(table, csg, node.solid, ray, there, crossings);
    i = there != 0 ? i + 1 : node.end;
  }
  return lanes;
}

/// Sorts the crossings of one lane and begins to follow them.
void start(const DoubleRay& ray, int lane, CsgCrossings& crossings, CsgSweep& sweep) {
  crossings.sort();
  const double speed = std::sqrt(ray.d[0][lane] * ray.d[0][lane] + ray.d[1][lane] * ray.d[1][lane] +
                                 ray.d[2][lane] * ray.d[2][lane]);
  sweep.start(crossings, kCsgCoincidence / speed);
}

/// Calls f(lane, ray of its part, its place in the part, sweep) for each active lane that may meet the whole
/// before its `t_far`, with the sweep at its start. Its borders behind that mean nothing.
template <class F>
void for_each_ray(const ShapeTable& table, const CsgRecord& csg, const ObjectRays& rays, F&& f) {
  const std::uint32_t wanted = rays.active.bits();
  alignas(64) float t_far[kWidth];
  rays.t_far.store(t_far);
  CsgSweep sweep(csg);
  for (int first = 0; first < kWidth; first += kDoubleWidth) {
    std::uint32_t lanes = wanted >> first & kPartLanes;
    if (lanes == 0) continue;
    const DoubleRay ray(rays, first);
    CsgCrossings crossings[kDoubleWidth];
    lanes = add_all_spans(table, csg, ray, BoxTest(ray, t_far + first), lanes, crossings);
    for (; lanes != 0; lanes &= lanes - 1) {
      const int i = __builtin_ctz(lanes);
      if (crossings[i].size() == 0) continue;
      start(ray, i, crossings[i], sweep);
      f(first + i, ray, i, sweep);
    }
  }
}

/// Which border the rays hit, found again: the one next to their `t`.
struct Borders {
  alignas(64) std::int32_t solid[kWidth] = {}, primitive[kWidth] = {}, painted[kWidth] = {};
  alignas(64) float p[3][kWidth] = {};  // render space
  std::uint32_t found = 0, enters = 0;  // lanes

  Borders(const ShapeTable& table, const CsgRecord& csg, const ObjectRays& rays, Float t) {
    alignas(64) float wanted[kWidth];
    t.store(wanted);
    for_each_ray(table, csg, rays, [&](int lane, const DoubleRay& ray, int i, CsgSweep& sweep) {
      float nearest = __builtin_inff();
      CsgBorder border;
      while (sweep.next(border)) {
        // Rounded like in nearest(), which met the first of those that are the same.
        const float off = std::abs(static_cast<float>(ray.t[i] + border.at.s) - wanted[lane]);
        if (!(off < nearest)) continue;
        nearest = off;
        found |= 1u << lane;
        if (border.enters)
          enters |= 1u << lane;
        else
          enters &= ~(1u << lane);
        solid[lane] = border.at.solid, primitive[lane] = border.at.primitive;
        painted[lane] = sweep.material_at(border);
        for (int a = 0; a < 3; ++a) {
          const float* const row = csg.render_from_unit.m + 4 * a;
          double sum = row[3];
          for (int b = 0; b < 3; ++b) sum += row[b] * (ray.o[b][i] + border.at.s * ray.d[b][i]);
          p[a][lane] = static_cast<float>(sum);
        }
      }
    });
  }
};

/// Solids that are combined; one primitive.
class CsgShape final : public AnalyticShape {
 public:
  ShapeBounds bounds(const ShapeTable& table, const ShapeRecord& shape, std::int32_t) const override {
    const CsgRecord& csg = record_of(table, shape);
    float centre[3], half[3];
    for (int i = 0; i < 3; ++i) {
      centre[i] = 0.5f * (csg.low[i] + csg.high[i]);
      half[i] = 0.5f * (csg.high[i] - csg.low[i]);
    }
    return placed_bounds(csg.render_from_unit, centre, half);
  }

  Float nearest(const ShapeTable& table, const ShapeRecord& shape, std::int32_t,
                const ShapeRays& rays) const override {
    const CsgRecord& csg = record_of(table, shape);
    alignas(64) float found[kWidth], near[kWidth];
    Float(-1.0f).store(found);
    rays.t_near.store(near);
    for_each_ray(table, csg, ObjectRays(csg.unit_from_render, rays),
                 [&](int lane, const DoubleRay& ray, int i, CsgSweep& sweep) {
                   CsgBorder border;
                   while (sweep.next(border)) {
                     const auto t = static_cast<float>(ray.t[i] + border.at.s);
                     if (!(t > near[lane])) continue;
                     found[lane] = t;
                     return;
                   }
                 });
    const Float t = Float::load(found);
    return select(rays.active & (t < rays.t_far), t, -1.0f);
  }

  /// All borders of one sweep: a line that is outside of the whole at both of its ends crosses an even
  /// number, however close they are to one another.
  void crossings(const ShapeTable& table, const ShapeRecord& shape, std::int32_t, const ExactRay& ray,
                 std::vector<double>& found) const override {
    const CsgRecord& csg = record_of(table, shape);
    const DoubleRay line(ExactObjectRay(csg.unit_from_render, ray));
    CsgCrossings crossings[kDoubleWidth];
    if (add_all_spans(table, csg, line, BoxTest(line), 1, crossings) == 0) return;
    CsgSweep sweep(csg);
    start(line, 0, crossings[0], sweep);
    CsgBorder border;
    while (sweep.next(border)) found.push_back(line.t[0] + border.at.s);
  }

  void surface(const ShapeTable& table, const ShapeRecord& shape, const Hit& hit, Vec3 o, Vec3 d, Mask active,
               bool want_tangents, Surface& s) const override {
    const CsgRecord& csg = record_of(table, shape);
    // A little behind the hit there may be borders that rounding puts at the same place.
    const Float enough = fma(hit.t, Float(1 + 0x1p-18f), Float(1e-37f));
    const ObjectRays rays(csg.unit_from_render, {o, d, Float(0.0f), enough, active});
    const Borders borders(table, csg, rays, hit.t);
    // Rays that miss everything when they are followed again touched the first solid, or it is as good.
    const Mask found = Mask::from_bits(borders.found);
    const Vec3 guess = fma(d, hit.t, o);
    const Vec3 p = select(
        found, Vec3{Float::load(borders.p[0]), Float::load(borders.p[1]), Float::load(borders.p[2])}, guess);
    for_each_distinct(Int::load(borders.solid), active, [&](std::int32_t index, Mask lanes) {
      const CsgSolid& solid = csg.solids[static_cast<std::size_t>(index)];
      const Hit own{Float(0.0f),      Float(0.0f), Float(0.0f), Int::load(borders.primitive),
                    Int(solid.shape), Int(-1)};
      Surface of_solid = surface_at(table, own, p, d, lanes, want_tangents);
      // Meshes may be wound either way; their faces are flat, so the ray tells which side it came from.
      const Mask against = dot(of_solid.ng, d) < 0.0f;
      Mask turn = solid.mesh >= 0 ? against ^ Mask::from_bits(borders.enters)
                  : solid.turned  ? Mask::all()
                                  : Mask::none();
      if (shape.flags & kFlipNormal) turn = ~turn;
      of_solid.ng = select(turn, -of_solid.ng, of_solid.ng);
      of_solid.ns = select(turn, -of_solid.ns, of_solid.ns);
      take(of_solid, lanes, want_tangents, s);
    });
    for_each_distinct(Int::load(borders.painted), active, [&](std::int32_t index, Mask lanes) {
      const CsgSolid& solid = csg.solids[static_cast<std::size_t>(index)];
      s.material =
          select(lanes, Int(table.shapes[static_cast<std::size_t>(solid.shape)].material), s.material);
    });
  }

 private:
  static void take(const Surface& from, Mask lanes, bool want_tangents, Surface& s) {
    s.p = select(lanes, from.p, s.p);
    // The placements of the solid and of the whole are rounded each by itself.
    s.error = select(lanes, from.error * 2.0f, s.error);
    s.ng = select(lanes, from.ng, s.ng);
    s.ns = select(lanes, from.ns, s.ns);
    s.uv = {select(lanes, from.uv.x, s.uv.x), select(lanes, from.uv.y, s.uv.y)};
    s.shape = select(lanes, from.shape, s.shape);
    s.primitive = select(lanes, from.primitive, s.primitive);
    s.barycentric = {select(lanes, from.barycentric.x, s.barycentric.x),
                     select(lanes, from.barycentric.y, s.barycentric.y)};
    if (!want_tangents) return;
    s.dpdu = select(lanes, from.dpdu, s.dpdu);
    s.dpdv = select(lanes, from.dpdv, s.dpdv);
  }
};

}  // namespace

const ModelOf<CsgShape> csg(ShapeKind::kCsg);

}  // namespace tessera::render::TESSERA_ISA
