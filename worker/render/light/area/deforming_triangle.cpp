#include "render/light/area/area_light.h"
#include "render/light/light.h"
#include "render/light/light_cone.h"
#include "render/sampling/warp.h"
#include "render/shape/key_vertices.h"
#include "render/shape/triangle_normal.h"
#include "render/shape/vertex_lanes.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// Triangles of meshes that deform, at the lanes' times.
struct DeformedTriangle {
  Vec3 corners[3];
  Vec3 e1, e2;
  Float size;  // largest coordinate of the sides

  explicit DeformedTriangle(const LightLanes& lanes) {
    const ShapeTable& shapes = *lanes.table.shapes;
    const Int shape = lanes.field(&LightRecord::shape);
    const auto of_shape = [&](std::int32_t ShapeRecord::*member) {
      return gather_member(shapes.shapes.data(), member, shape, lanes.active);
    };
    const KeyLanes key(shapes, shape, lanes.time, lanes.active);
    const Int row = (of_shape(&ShapeRecord::first_triangle) + lanes.field(&LightRecord::primitive)) * 3;
    const Int first = of_shape(&ShapeRecord::first_vertex) + key.before * key.vertices;
    const auto* const indices = reinterpret_cast<const std::int32_t*>(shapes.triangles.data());
    for (int c = 0; c < 3; ++c) {
      const Int vertex = first + gather(indices + c, row, lanes.active);
      VertexLanes corner(shapes, vertex, lanes.active);
      corner.mix_position({shapes, vertex + key.vertices, lanes.active}, key.part, lanes.active);
      corners[c] = corner.position();
    }
    e1 = corners[1] - corners[0], e2 = corners[2] - corners[0];
    size = max(max_abs(e1), max_abs(e2));
  }

  Float area() const {
    const Float scale = scale_of_sides(size);
    return 0.5f * length(cross(e1 * scale, e2 * scale)) / sqr(scale);
  }
};

/// A triangle of an emitting mesh that deforms, sampled uniformly by area.
class DeformingTriangleLight final : public AreaLight {
 protected:
  AreaPoint sample_point(const LightLanes& lanes, Vec2 u) const override {
    const DeformedTriangle t(lanes);
    const Barycentric b = square_to_triangle(u);
    return {fma(t.corners[2], b.b2, fma(t.corners[1], b.b1, t.corners[0] * b.b0)),
            triangle_normal(t.e1, t.e2, t.size),
            1.0f / t.area(),
            t.size,
            {b.b1, b.b2}};
  }
  Float density_at(const LightLanes& lanes, Vec3) const override {
    return 1.0f / DeformedTriangle(lanes).area();
  }
  void bound(const LightTable& table, const LightRecord& light, LightBounds& b) const override {
    const ShapeTable& shapes = *table.shapes;
    const ShapeRecord& mesh = shapes.shapes[static_cast<std::size_t>(light.shape)];
    const std::uint32_t* const row =
        shapes.triangles.data() +
        3 * (static_cast<std::size_t>(mesh.first_triangle) + static_cast<std::size_t>(light.primitive));
    const auto corner = [&](int c, std::int32_t key) {
      return vec64::vec(key_vertex(shapes, mesh, row[c], key).position);
    };
    // Sides are linear between two keys, their cross product is quadratic: it stays between three control
    // points.
    std::vector<vec64::Vec> normals;
    for (std::int32_t key = 0; key <= mesh.key_segments; ++key) {
      const vec64::Vec e1 = corner(1, key) - corner(0, key), e2 = corner(2, key) - corner(0, key);
      if (key > 0) {
        const vec64::Vec d1 = corner(1, key - 1) - corner(0, key - 1),
                         d2 = corner(2, key - 1) - corner(0, key - 1);
        normals.push_back((cross(d1, e2) + cross(e1, d2)) * 0.5);
      }
      normals.push_back(cross(e1, e2));
      for (int c = 0; c < 3; ++c) b.add(corner(c, key));
    }
    std::erase_if(normals, [](const vec64::Vec& n) { return !(length(n) > 0); });
    set_cone(normals, 0, b);
  }
};

}  // namespace

const ModelOf<DeformingTriangleLight> deforming_triangle(LightKind::kDeformingTriangle);

}  // namespace tessera::render::TESSERA_ISA
