#include "render/textbook/radiosity/patches.h"

#include <algorithm>

namespace tessera::render::TESSERA_ISA::radiosity {

namespace {

Weights middle(const Weights& a, const Weights& b) {
  return {{(a.w[0] + b.w[0]) / 2, (a.w[1] + b.w[1]) / 2, (a.w[2] + b.w[2]) / 2}};
}

Vec placed(const Affine& to, const float* p) {
  const float* m = to.m;
  Vec result;
  for (std::size_t row = 0; row < 3; ++row) {
    result[row] = double{m[4 * row]} * p[0] + double{m[4 * row + 1]} * p[1] + double{m[4 * row + 2]} * p[2] +
                  m[4 * row + 3];
  }
  return result;
}

bool mirrors(const Affine& to) {
  const float* m = to.m;
  return dot(Vec{m[0], m[1], m[2]}, cross(Vec{m[4], m[5], m[6]}, Vec{m[8], m[9], m[10]})) < 0;
}

}  // namespace

Corners corners_of(Name patch) {
  Corners c{{{{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}}}};
  for (int level = 0; level < patch.level(); ++level) {
    const Weights m01 = middle(c.at[0], c.at[1]), m12 = middle(c.at[1], c.at[2]),
                  m20 = middle(c.at[2], c.at[0]);
    switch (patch.part_at(level)) {
      case 0:
        c = {{c.at[0], m01, m20}};
        break;
      case 1:
        c = {{m01, c.at[1], m12}};
        break;
      case 2:
        c = {{m20, m12, c.at[2]}};
        break;
      default:
        c = {{m12, m20, m01}};
    }
  }
  return c;
}

double Patch::radius() const {
  const Vec c = centre();
  return std::max({length(corner[0] - c), length(corner[1] - c), length(corner[2] - c)});
}

Surfaces::Surfaces(const ShapeTable& shapes) {
  const auto world = static_cast<std::size_t>(shapes.world_shape_count);
  for (std::size_t shape = 0; shape < world; ++shape) add_shape(shapes, shape, -1);
  for (std::size_t i = 0; i < shapes.instances.size(); ++i) {
    const ObjectRange& object = shapes.objects[static_cast<std::size_t>(shapes.instances[i].object)];
    const auto first = static_cast<std::size_t>(object.first_shape);
    first_placed_.push_back(first_triangle_.size() - first);
    for (std::size_t s = first; s < first + static_cast<std::size_t>(object.shape_count); ++s)
      add_shape(shapes, s, static_cast<std::int32_t>(i));
  }
  for (const Triangle& triangle : triangles_) whole_area_ += triangle.area;
}

void Surfaces::add_shape(const ShapeTable& shapes, std::size_t shape, std::int32_t instance) {
  first_triangle_.push_back(static_cast<Side>(triangles_.size()));
  const ShapeRecord& record = shapes.shapes[shape];
  for (std::int32_t primitive = 0; primitive < record.triangle_count; ++primitive) {
    Triangle triangle;
    triangle.origin = {static_cast<std::int32_t>(shape), primitive, instance};
    const std::size_t first = 3 * static_cast<std::size_t>(record.first_triangle + primitive);
    triangle.turned = false;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t vertex =
          static_cast<std::size_t>(record.first_vertex) + std::size_t{shapes.triangles[first + i]};
      const float* const p = shapes.vertices[vertex].position;
      if (instance < 0) {
        triangle.corner[i] = vec64::vec(p);
      } else {
        const Affine& to = shapes.instances[static_cast<std::size_t>(instance)].render_from_instance;
        triangle.corner[i] = placed(to, p);
        triangle.turned = mirrors(to);
      }
    }
    const Vec across =
        cross(triangle.corner[1] - triangle.corner[0], triangle.corner[2] - triangle.corner[0]);
    triangle.area = length(across) / 2;
    triangle.normal = vec64::unit(across) * (triangle.turned ? -1 : 1);
    triangles_.push_back(triangle);
  }
}

Patch Surfaces::patch(Name name) const {
  const Triangle& triangle = triangles_[name.side() / 2];
  Patch result{{triangle.corner[0], triangle.corner[1], triangle.corner[2]},
               triangle.normal * (name.side() % 2 == 0 ? 1 : -1),
               triangle.area};
  if (name.level() == 0) return result;
  const Patch whole = result;
  const Corners corners = corners_of(name);
  for (int i = 0; i < 3; ++i) result.corner[i] = whole.point(corners.at[i]);
  result.area = whole.area / static_cast<double>(std::uint64_t{1} << (2 * name.level()));
  return result;
}

}  // namespace tessera::render::TESSERA_ISA::radiosity
