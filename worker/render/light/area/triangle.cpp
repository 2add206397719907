#include "render/core/constants.h"
#include "render/light/area/area_light.h"
#include "render/light/area/rectangle_build.h"
#include "render/light/light.h"
#include "render/sampling/warp.h"
#include "render/shape/key_vertices.h"
#include "render/shape/triangle_normal.h"

namespace tessera::render::TESSERA_ISA {
namespace {

/// Returns where the table has the triangle that the light is.
std::size_t triangle_of(const ShapeRecord& shape, const LightRecord& light) {
  return static_cast<std::size_t>(shape.first_triangle) + static_cast<std::size_t>(light.primitive);
}

void describe_triangle(const ShapeTable& table, const ShapeRecord& shape, LightRecord& light) {
  const std::size_t triangle = triangle_of(shape, light);
  vec64::Vec p[3];
  for (std::size_t corner = 0; corner < 3; ++corner) {
    const std::size_t vertex =
        static_cast<std::size_t>(shape.first_vertex) + table.triangles[triangle * 3 + corner];
    for (std::size_t i = 0; i < 3; ++i)
      p[corner][i] = light.vertices[corner * 3 + i] = table.vertices[vertex].position[i];
  }
  const vec64::Vec e1 = {p[1][0] - p[0][0], p[1][1] - p[0][1], p[1][2] - p[0][2]};
  const vec64::Vec e2 = {p[2][0] - p[0][0], p[2][1] - p[0][1], p[2][2] - p[0][2]};
  light.area = static_cast<float>(0.5 * length(cross(e1, e2)));
}

/// Whether the normals at the corners of a triangle light turn away from its own by more than roundings.
bool is_smooth(const ShapeTable& table, const ShapeRecord& shape, const LightRecord& light) {
  if (!(shape.flags & kHasNormals)) return false;
  const std::size_t triangle = triangle_of(shape, light);
  const float* v = light.vertices;
  const vec64::Vec n = vec64::cross({double{v[3]} - v[0], double{v[4]} - v[1], double{v[5]} - v[2]},
                                    {double{v[6]} - v[0], double{v[7]} - v[1], double{v[8]} - v[2]});
  for (std::size_t corner = 0; corner < 3; ++corner) {
    const std::size_t vertex =
        static_cast<std::size_t>(shape.first_vertex) + table.triangles[triangle * 3 + corner];
    const float* at = table.vertices[vertex].normal;
    const vec64::Vec normal = {at[0], at[1], at[2]};
    if (length(cross(n, normal)) > 1e-4 * length(n) * length(normal)) return true;
  }
  return false;
}

/// Mean area over time of a triangle of a mesh that deforms, by its keys and the middles between them.
float mean_area(const ShapeTable& table, const ShapeRecord& mesh, const LightRecord& light) {
  double sum = 0;
  const std::int32_t steps = 2 * mesh.key_segments;
  for (std::int32_t step = 0; step <= steps; ++step) {
    float p[3][3];
    corners_at(table, mesh, light.primitive, static_cast<float>(step) / static_cast<float>(steps), p);
    sum += 0.5 * length(cross(vec64::vec(p[1]) - vec64::vec(p[0]), vec64::vec(p[2]) - vec64::vec(p[0])));
  }
  return static_cast<float>(sum / (steps + 1));
}

void append_deforming_triangles(const ShapeTable& shapes, const ShapeRecord& record, LightRecord light,
                                std::vector<LightRecord>& lights) {
  light.kind = LightKind::kDeformingTriangle;
  for (light.primitive = 0; light.primitive < record.triangle_count; ++light.primitive) {
    light.area = mean_area(shapes, record, light);
    lights.push_back(light);
  }
}

void append_triangles(const ShapeTable& shapes, const ShapeRecord& record, float interpolated_pick,
                      LightRecord light, std::vector<LightRecord>& lights) {
  const std::size_t first = lights.size();
  double area = 0;
  for (light.primitive = 0; light.primitive < record.triangle_count; ++light.primitive) {
    describe_triangle(shapes, record, light);
    area += light.area;
    const bool smooth = interpolated_pick > 0 && is_smooth(shapes, record, light);
    light.profile = smooth ? kInterpolated : kPlainProfile;
    lights.push_back(light);
    if (light.primitive > 0 && !smooth && lights.end()[-2].profile == kPlainProfile)
      merge_into_rectangle(lights.end()[-2], static_cast<std::int32_t>(lights.size()) - 2, lights.back());
  }
  for (std::size_t i = first; i < lights.size(); ++i) {
    if (lights[i].profile != kInterpolated) continue;
    lights[i].tan_x = interpolated_pick;
    lights[i].tan_y = static_cast<float>(area);
  }
}

/// One triangle of an emitting mesh, sampled uniformly by area.
class TriangleLight final : public AreaLight {
 public:
  TriangleLight() : AreaLight({.surface = ShapeKind::kTriangles}) {}

  /// One a triangle; two in a row that make a rectangle, without a texture, become one light.
  void append(const ShapeTable& shapes, const ShapeRecord& shape, const LightRecord& light,
              float interpolated_pick, std::vector<LightRecord>& lights) const override {
    if (shape.key_segments > 0) return append_deforming_triangles(shapes, shape, light, lights);
    append_triangles(shapes, shape, interpolated_pick, light, lights);
  }

 protected:
  AreaPoint sample_point(const LightLanes& lanes, Vec2 u) const override {
    const Vec3 p0 = lanes.field3(&LightRecord::vertices, 0);
    const Vec3 p1 = lanes.field3(&LightRecord::vertices, 3);
    const Vec3 p2 = lanes.field3(&LightRecord::vertices, 6);
    const Vec3 e1 = p1 - p0, e2 = p2 - p0;
    const Float size = max(max_abs(e1), max_abs(e2));
    const Barycentric b = square_to_triangle(u);
    return {fma(p2, b.b2, fma(p1, b.b1, p0 * b.b0)),
            triangle_normal(e1, e2, size),
            1.0f / lanes.field(&LightRecord::area),
            size,
            {b.b1, b.b2}};
  }
  void bound(const LightTable& table, const LightRecord& light, LightBounds& b) const override {
    const vec64::Vec p0 = vec64::vec(light.vertices), p1 = vec64::vec(light.vertices + 3),
                     p2 = vec64::vec(light.vertices + 6);
    b.axis = unit(cross(p1 - p0, p2 - p0));
    for (const vec64::Vec& p : {p0, p1, p2}) b.add(p);
  }
};

}  // namespace

const ModelOf<TriangleLight> triangle(LightKind::kTriangle);

}  // namespace tessera::render::TESSERA_ISA
