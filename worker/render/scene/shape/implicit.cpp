// Implicit surfaces: from text to a program, and to coefficients where it is a polynomial.
#include <cmath>

#include "absl/strings/str_cat.h"
#include "expression/polynomial.h"
#include "render/scene/shape/geometry.h"
#include "render/scene/shape/shape_kinds.h"
#include "render/scene/values/located.h"
#include "render/shape/implicit/set_polynomial.h"

namespace tessera::render {

namespace {

absl::Status set_bounds(const v1::ImplicitSurface& surface, ImplicitRecord& record) {
  const auto set = [&](const v1::Point3& low, const v1::Point3& high) {
    const double from[] = {low.x(), low.y(), low.z()}, to[] = {high.x(), high.y(), high.z()};
    for (int i = 0; i < 3; ++i)
      record.low[i] = static_cast<float>(from[i]), record.high[i] = static_cast<float>(to[i]);
  };
  if (surface.has_box()) {
    set(surface.box().low(), surface.box().high());
  } else if (surface.has_ball()) {
    const v1::Point3& c = surface.ball().center();
    const double r = surface.ball().radius(), at[] = {c.x(), c.y(), c.z()};
    if (!(r > 0)) return absl::InvalidArgumentError("the ball that bounds an implicit surface has no radius");
    record.in_sphere = 1;
    record.radius = static_cast<float>(r);
    for (int i = 0; i < 3; ++i) {
      record.centre[i] = static_cast<float>(at[i]);
      // A little more: rounded inwards it would cut the sphere.
      record.low[i] = std::nextafter(static_cast<float>(at[i] - r), -HUGE_VALF);
      record.high[i] = std::nextafter(static_cast<float>(at[i] + r), HUGE_VALF);
    }
  } else {
    return absl::InvalidArgumentError("an implicit surface needs bounds: a box or a ball");
  }
  for (int i = 0; i < 3; ++i) {
    if (!(record.low[i] < record.high[i]) || !std::isfinite(record.high[i] - record.low[i]))
      return absl::InvalidArgumentError("the bounds of an implicit surface have no volume");
  }
  return absl::OkStatus();
}

absl::Status set_roots(const v1::ImplicitSurface& surface, ImplicitRecord& record) {
  const double lipschitz = surface.lipschitz();
  if (!(lipschitz >= 0)) return absl::InvalidArgumentError("a Lipschitz bound is a number above 0");
  const auto of_polynomials = [&](const char* method, ImplicitRoots roots) {
    record.roots = roots;
    if (record.degree > 0) return absl::OkStatus();
    return absl::InvalidArgumentError(absl::StrCat(method, " is for polynomials of degree 1 to ",
                                                   expression::kMaxDegree, "; this is another function"));
  };
  absl::Status status;
  switch (surface.roots()) {
    case v1::ImplicitSurface::STURM:
      status = of_polynomials("sturm", ImplicitRoots::kSturm);
      break;
    case v1::ImplicitSurface::NEWTON:
      status = of_polynomials("newton", ImplicitRoots::kNewton);
      break;
    default:
      record.roots = ImplicitRoots::kInterval;
  }
  if (lipschitz > 0) record.roots = ImplicitRoots::kSphereTracing, record.lipschitz = lipschitz;
  return status;
}

absl::Status add_implicit(const ShapeToAdd& wanted) {
  const v1::Shape& shape = wanted.shape;
  const Transform& placed_from_object = wanted.placed_from_object;
  Transform object_from_placed;
  if (!placed_from_object.invert(object_from_placed))
    return absl::InvalidArgumentError("its transform is singular");
  if (!fits_floats(placed_from_object, object_from_placed)) return absl::InvalidArgumentError(kBeyondFloats);
  ImplicitRecord surface;
  surface.render_from_object = placed_from_object.to_affine();
  surface.object_from_render = object_from_placed.to_affine();
  if (auto s = set_bounds(shape.implicit(), surface); !s.ok()) return s;

  const auto parsed = expression::parse(shape.implicit().expression());
  if (!parsed.ok()) return located(parsed.status(), "expression");
  auto program = expression::compile(*parsed);
  if (!program.ok()) return located(program.status(), "expression");
  surface.program = *std::move(program);
  if (const auto polynomial = expression::expand(*parsed)) {
    if (polynomial->degree == 0)
      return absl::InvalidArgumentError("expression: a constant, which has no surface");
    set_polynomial(*polynomial, surface);
    if (!(surface.magnitude < 1e200) || !(surface.slope < 1e200))
      return absl::InvalidArgumentError("expression: its values within the bounds are beyond 1e200");
  }
  if (auto s = set_roots(shape.implicit(), surface); !s.ok()) return s;

  wanted.record.kind = ShapeKind::kImplicit;
  if (shape.reverse_orientation() != (placed_from_object.determinant() < 0))
    wanted.record.flags |= kFlipNormal;
  wanted.record.quadric = static_cast<std::int32_t>(wanted.table.implicits.size());
  wanted.table.implicits.push_back(std::move(surface));
  if (wanted.exact != nullptr) *wanted.exact = placed_from_object;
  return absl::OkStatus();
}

// In combinations its bounds are a solid of their own, which has the box.
constexpr ShapeKindRow kImplicit{.message = v1::Shape::kImplicit,
                                 .add = &add_implicit,
                                 .without_light = [](const v1::Shape&) { return "an implicit surface"; }};

}  // namespace

std::span<const ShapeKindRow> implicit_kinds() { return {&kImplicit, 1}; }

}  // namespace tessera::render
