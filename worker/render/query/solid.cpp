#include "render/query/solid.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace tessera::render {
namespace {

const QuadricRecord& quadric_of(const ShapeTable& table, const ShapeRecord& shape) {
  return table.quadrics[static_cast<std::size_t>(shape.quadric)];
}

std::span<const Facet> facets_of(const ShapeTable& table, const QuadricRecord& q) {
  return {table.facets.data() + q.first_facet, static_cast<std::size_t>(q.facet_count)};
}

double above(const Facet& facet, const V3d& p) {
  return to_point(facet.normal).dot(p) - double{facet.offset};
}

/// The value at a point of the unit cube of a trilinear grid; above 0 outside of it.
double grid_value(const SdfGridRecord& grid, const V3d& p) {
  std::size_t low[3];
  double part[3];
  for (int k = 0; k < 3; ++k) {
    const double place = p[k] * (grid.size[k] - 1);
    if (!(place >= 0 && place <= grid.size[k] - 1)) return 1;
    low[k] = static_cast<std::size_t>(std::min(std::floor(place), double(grid.size[k] - 2)));
    part[k] = place - static_cast<double>(low[k]);
  }
  const auto row = static_cast<std::size_t>(grid.size[0]),
             slice = row * static_cast<std::size_t>(grid.size[1]);
  double value = 0;
  for (std::size_t corner = 0; corner < 8; ++corner) {
    const std::size_t x = corner & 1, y = corner >> 1 & 1, z = corner >> 2;
    value += (x ? part[0] : 1 - part[0]) * (y ? part[1] : 1 - part[1]) * (z ? part[2] : 1 - part[2]) *
             double{grid.samples[low[0] + x + (low[1] + y) * row + (low[2] + z) * slice]};
  }
  return value;
}

bool in_bounds(const ImplicitRecord& surface, const V3d& p) {
  double from_centre = 0;
  for (int k = 0; k < 3; ++k) {
    if (!(p[k] >= double{surface.low[k]} && p[k] <= double{surface.high[k]})) return false;
    from_centre += (p[k] - double{surface.centre[k]}) * (p[k] - double{surface.centre[k]});
  }
  return !surface.in_sphere || from_centre <= double{surface.radius} * surface.radius;
}

/// In object space; of solids with plane faces.
bool in_flat(const ShapeTable& table, const ShapeRecord& shape, const V3d& p) {
  const QuadricRecord& q = quadric_of(table, shape);
  switch (shape.kind) {
    case ShapeKind::kBox:
      return std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) < 1;
    case ShapeKind::kPolyhedron:
      return std::ranges::all_of(facets_of(table, q), [&](const Facet& f) { return above(f, p) < 0; });
    default:
      return p.z < 0;  // kHalfSpace
  }
}

/// The face that lies in one plane of a convex solid: a square that is larger than it, cut by the others.
Face cut_face(std::span<const Facet> facets, std::size_t which) {
  const V3d n = to_point(facets[which].normal).normalized();
  const V3d u = (std::abs(n.x) < 0.6 ? V3d(1, 0, 0) : V3d(0, 1, 0)).cross(n).normalized(), v = n.cross(u);
  const V3d middle = n * (double{facets[which].offset} / to_point(facets[which].normal).length());
  constexpr double kReach = 4;  // the solid lies in the cube from -1 to 1
  Face face{middle - (u + v) * kReach, middle + (u - v) * kReach, middle + (u + v) * kReach,
            middle - (u - v) * kReach};
  for (std::size_t i = 0; i < facets.size() && !face.empty(); ++i) {
    if (i == which) continue;
    Face kept;
    for (std::size_t k = 0; k < face.size(); ++k) {
      const V3d &a = face[k], &b = face[(k + 1) % face.size()];
      const double ha = above(facets[i], a), hb = above(facets[i], b);
      if (ha <= 0) kept.push_back(a);
      if ((ha < 0 && hb > 0) || (ha > 0 && hb < 0)) kept.push_back(a + (b - a) * (ha / (ha - hb)));
    }
    face = std::move(kept);
  }
  return face;
}

}  // namespace

ExactAffine placed_from_object(const ShapeTable& table, const ShapeRecord& shape) {
  constexpr ExactAffine kHere{{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
  switch (shape.kind) {
    case ShapeKind::kTriangles:
    case ShapeKind::kCurves:
    case ShapeKind::kCsg:
      return kHere;
    case ShapeKind::kSdfGrid:
      return exact(table.sdf_grids[static_cast<std::size_t>(shape.quadric)].render_from_object);
    case ShapeKind::kImplicit:
      return exact(table.implicits[static_cast<std::size_t>(shape.quadric)].render_from_object);
    default:
      return shape.kind < ShapeKind::kCount ? exact(quadric_of(table, shape).render_from_object) : kHere;
  }
}

std::optional<bool> bounds_solid(const ShapeTable& table, const ShapeRecord& shape,
                                 const QueryKernel& kernel) {
  if (const RoundForm* const form = kernel.round_form(shape.kind))
    return form->is_solid(quadric_of(table, shape));
  switch (shape.kind) {
    case ShapeKind::kHalfSpace:
    case ShapeKind::kBox:
    case ShapeKind::kPolyhedron:
    case ShapeKind::kSdfGrid:
    case ShapeKind::kImplicit:
      return true;
    case ShapeKind::kPolygon:
      return false;
    default:
      return std::nullopt;
  }
}

std::optional<bool> in_solid(const ShapeTable& table, const ShapeRecord& shape, const QueryKernel& kernel,
                             const V3d& p) {
  if (!bounds_solid(table, shape, kernel).value_or(false)) return std::nullopt;
  const V3d at = apply(inverse(placed_from_object(table, shape)), p);
  if (shape.kind == ShapeKind::kSdfGrid)
    return grid_value(table.sdf_grids[static_cast<std::size_t>(shape.quadric)], at) < 0;
  if (shape.kind == ShapeKind::kImplicit) {
    const ImplicitRecord& surface = table.implicits[static_cast<std::size_t>(shape.quadric)];
    return in_bounds(surface, at) && kernel.implicit_value(surface, {at.x, at.y, at.z}) < 0;
  }
  if (const RoundForm* const form = kernel.round_form(shape.kind))
    return form->contains(quadric_of(table, shape), {at.x, at.y, at.z});
  return in_flat(table, shape, at);
}

std::optional<double> support(const ShapeTable& table, const ShapeRecord& shape, const QueryKernel& kernel,
                              const V3d& a) {
  if (const RoundForm* const form = kernel.round_form(shape.kind)) {
    const QuadricRecord& q = quadric_of(table, shape);
    return q.partial ? std::nullopt : std::optional(form->support(q, {a.x, a.y, a.z}));
  }
  const std::vector<Face> faces = plane_faces(table, shape);
  if (faces.empty()) return std::nullopt;
  double most = -HUGE_VAL;
  for (const Face& face : faces) {
    for (const V3d& p : face) most = std::max(most, a.dot(p));
  }
  return most;
}

std::vector<Face> plane_faces(const ShapeTable& table, const ShapeRecord& shape) {
  switch (shape.kind) {
    case ShapeKind::kPolygon: {
      Face face;
      for (const Facet& corner : facets_of(table, quadric_of(table, shape)))
        face.emplace_back(corner.normal[0], corner.normal[1], 0);
      return {face};
    }
    case ShapeKind::kHalfSpace: {
      const double r = quadric_of(table, shape).radius;
      return {{{-r, -r, 0}, {r, -r, 0}, {r, r, 0}, {-r, r, 0}}};
    }
    case ShapeKind::kBox: {
      std::vector<Face> faces;
      for (int axis = 0; axis < 3; ++axis) {
        for (const double side : {-1.0, 1.0}) {
          const auto corner = [&](double a, double b) {
            V3d p;
            p[axis] = side, p[(axis + 1) % 3] = a, p[(axis + 2) % 3] = b;
            return p;
          };
          faces.push_back({corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1)});
        }
      }
      return faces;
    }
    case ShapeKind::kPolyhedron: {
      const std::span<const Facet> facets = facets_of(table, quadric_of(table, shape));
      std::vector<Face> faces;
      for (std::size_t i = 0; i < facets.size(); ++i) {
        Face face = cut_face(facets, i);
        if (face.size() >= 3) faces.push_back(std::move(face));
      }
      return faces;
    }
    default:
      return {};
  }
}

}  // namespace tessera::render
