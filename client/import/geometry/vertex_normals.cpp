#include "import/geometry/vertex_normals.h"

#include <algorithm>
#include <cmath>

#include "import/geometry/transform.h"

namespace tessera::client {
namespace {

double angle_between(const Imath::V3d& a, const Imath::V3d& b) {
  return std::atan2(length(a.cross(b)), a.dot(b));
}

}  // namespace

void compute_vertex_normals(wire::MeshData& mesh, const Imath::M44d& world_from_object) {
  const std::size_t vertices = mesh.positions.size() / 3;
  std::vector<Imath::V3d> sums(vertices, Imath::V3d{0, 0, 0});
  const auto placed = [&](std::uint32_t index) {
    const float* p = &mesh.positions[3 * std::size_t{index}];
    return transformed_vector({p[0], p[1], p[2]}, world_from_object);
  };
  // Faces keep their side when the transformation mirrors them.
  const double side = determinant3(world_from_object) < 0 ? -1 : 1;
  for (std::size_t t = 0; t < mesh.indices.size(); t += 3) {
    const std::uint32_t* corner = &mesh.indices[t];
    const Imath::V3d p[] = {placed(corner[0]), placed(corner[1]), placed(corner[2])};
    const Imath::V3d normal = (p[1] - p[0]).cross(p[2] - p[0]);
    const double area = length(normal);
    if (!(area > 0)) continue;
    for (int k = 0; k < 3; ++k) {
      const double angle = angle_between(p[(k + 1) % 3] - p[k], p[(k + 2) % 3] - p[k]);
      for (int a = 0; a < 3; ++a) sums[corner[k]][a] += side * normal[a] / area * angle;
    }
  }
  mesh.normals.resize(3 * vertices);
  const Imath::M44d object_from_world_for_normals = world_from_object.transposed();
  for (std::size_t v = 0; v < vertices; ++v) {
    Imath::V3d n = transformed_vector(sums[v], object_from_world_for_normals);
    const double l = length(n);
    n = l > 0 && std::isfinite(l) ? Imath::V3d{n[0] / l, n[1] / l, n[2] / l} : Imath::V3d{1, 0, 0};
    for (int a = 0; a < 3; ++a) mesh.normals[3 * v + a] = static_cast<float>(n[a]);
  }
}

bool keeps_angles(const Imath::M44d& t) {
  // Transposed times itself must be a multiple of the identity.
  constexpr double kRounding = 1e-5;  // error of matrices written with seven digits
  double gram[3][3];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) gram[i][j] = t[i][0] * t[j][0] + t[i][1] * t[j][1] + t[i][2] * t[j][2];
  }
  const double scale = gram[0][0];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      if (!(std::abs(gram[i][j] - (i == j ? scale : 0)) <= kRounding * scale)) return false;
    }
  }
  return true;
}

}  // namespace tessera::client
