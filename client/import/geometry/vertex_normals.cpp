#include "import/geometry/vertex_normals.h"

#include <algorithm>
#include <cmath>

#include "import/geometry/vector3.h"

namespace tessera::client {
namespace {

double angle_between(const Vector3& a, const Vector3& b) {
  return std::atan2(length(cross(a, b)), dot(a, b));
}

}  // namespace

void compute_vertex_normals(wire::MeshData& mesh, const Transform& world_from_object) {
  const std::size_t vertices = mesh.positions.size() / 3;
  std::vector<Vector3> sums(vertices, Vector3{0, 0, 0});
  const auto placed = [&](std::uint32_t index) {
    const float* p = &mesh.positions[3 * std::size_t{index}];
    return world_from_object.apply_to_vector({p[0], p[1], p[2]});
  };
  // Faces keep their side when the transformation mirrors them.
  const double side = world_from_object.determinant3() < 0 ? -1 : 1;
  for (std::size_t t = 0; t < mesh.indices.size(); t += 3) {
    const std::uint32_t* corner = &mesh.indices[t];
    const Vector3 p[] = {placed(corner[0]), placed(corner[1]), placed(corner[2])};
    const Vector3 normal = cross(p[1] - p[0], p[2] - p[0]);
    const double area = length(normal);
    if (!(area > 0)) continue;
    for (int k = 0; k < 3; ++k) {
      const double angle = angle_between(p[(k + 1) % 3] - p[k], p[(k + 2) % 3] - p[k]);
      for (int a = 0; a < 3; ++a) sums[corner[k]][a] += side * normal[a] / area * angle;
    }
  }
  mesh.normals.resize(3 * vertices);
  const Transform object_from_world_for_normals = transposed(world_from_object);
  for (std::size_t v = 0; v < vertices; ++v) {
    Vector3 n = object_from_world_for_normals.apply_to_vector(sums[v]);
    const double l = length(n);
    n = l > 0 && std::isfinite(l) ? Vector3{n[0] / l, n[1] / l, n[2] / l} : Vector3{1, 0, 0};
    for (int a = 0; a < 3; ++a) mesh.normals[3 * v + a] = static_cast<float>(n[a]);
  }
}

bool keeps_angles(const Transform& t) {
  // Transposed times itself must be a multiple of the identity.
  constexpr double kRounding = 1e-5;  // of matrices written with seven digits
  double gram[3][3];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) gram[i][j] = t(0, i) * t(0, j) + t(1, i) * t(1, j) + t(2, i) * t(2, j);
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
