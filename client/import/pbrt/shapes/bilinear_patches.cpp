#include "import/pbrt/shapes/bilinear_patches.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "import/geometry/transform.h"

namespace tessera::client::pbrt {
namespace {

struct Patch {
  const wire::MeshData& corners;
  const std::uint32_t* index;  // p00 p10 p01 p11

  Imath::V3d position(int k) const {
    const float* p = &corners.positions[3 * std::size_t{index[k]}];
    return {p[0], p[1], p[2]};
  }

  /// One number an array entry `stride` apart, bilinear between the corners.
  double blend(const std::vector<float>& values, std::size_t stride, std::size_t component, double u,
               double v) const {
    const auto at = [&](int k) { return double{values[stride * index[k] + component]}; };
    // Along an edge only its own two corners count, so that neighbours compute the same points.
    return std::lerp(std::lerp(at(0), at(1), u), std::lerp(at(2), at(3), u), v);
  }

  Imath::V3d normal(double u, double v) const {
    const Imath::V3d p00 = position(0), p10 = position(1), p01 = position(2), p11 = position(3);
    Imath::V3d along_u, along_v;
    for (std::size_t a = 0; a < 3; ++a) {
      along_u[a] = std::lerp(p10[a] - p00[a], p11[a] - p01[a], v);
      along_v[a] = std::lerp(p01[a] - p00[a], p11[a] - p10[a], u);
    }
    return along_u.cross(along_v);
  }
};

struct Warp {
  double twist = 0;   // how far the fourth corner is from that of a parallelogram, of the patch's size
  double height = 0;  // how far it is from the plane of the others
};

Warp warp_of(const Patch& patch) {
  const Imath::V3d u = patch.position(1) - patch.position(0), v = patch.position(2) - patch.position(0);
  const Imath::V3d w = patch.position(3) - patch.position(0);
  const double size = std::max({length(u), length(v), length(w)});
  if (!(size > 0)) return {};
  const Imath::V3d twist = w - u - v;
  const Imath::V3d n = u.cross(v);
  const double n_length = length(n);
  const double height = n_length > 0 ? std::abs(n[0] * w[0] + n[1] * w[1] + n[2] * w[2]) / n_length : 0;
  return {length(twist) / size, height / size};
}

void append_patch(const Patch& patch, int steps, bool with_normals, wire::MeshData& mesh) {
  const wire::MeshData& corners = patch.corners;
  const auto first = static_cast<std::uint32_t>(mesh.positions.size() / 3);
  for (int j = 0; j <= steps; ++j) {
    for (int i = 0; i <= steps; ++i) {
      const double u = static_cast<double>(i) / steps, v = static_cast<double>(j) / steps;
      for (std::size_t a = 0; a < 3; ++a) {
        mesh.positions.push_back(static_cast<float>(patch.blend(corners.positions, 3, a, u, v)));
      }
      if (with_normals) {
        const Imath::V3d n = corners.normals.empty() ? patch.normal(u, v)
                                                     : Imath::V3d{patch.blend(corners.normals, 3, 0, u, v),
                                                                  patch.blend(corners.normals, 3, 1, u, v),
                                                                  patch.blend(corners.normals, 3, 2, u, v)};
        append_floats(mesh.normals, n);
      }
      const bool has_uvs = !corners.uvs.empty();
      mesh.uvs.push_back(static_cast<float>(has_uvs ? patch.blend(corners.uvs, 2, 0, u, v) : u));
      mesh.uvs.push_back(static_cast<float>(has_uvs ? patch.blend(corners.uvs, 2, 1, u, v) : v));
    }
  }
  const auto row = static_cast<std::uint32_t>(steps + 1);
  for (std::uint32_t j = 0; j + 1 < row; ++j) {
    for (std::uint32_t i = 0; i + 1 < row; ++i) {
      const std::uint32_t c = first + j * row + i;
      mesh.indices.insert(mesh.indices.end(), {c, c + 1, c + row + 1, c, c + row + 1, c + row});
    }
  }
}

}  // namespace

BilinearTessellation tessellate_patches(const wire::MeshData& corners,
                                        const std::vector<std::uint32_t>& indices) {
  // Shares of a patch's size. Exporters' roundings make the first of a parallelogram.
  constexpr double kFlat = 1e-3, kTolerance = 2.5e-4;
  constexpr double kMostCells = 4e6;  // total of all patches
  Warp warp;
  for (std::size_t i = 0; i < indices.size(); i += 4) {
    const Warp one = warp_of({corners, &indices[i]});
    warp.twist = std::max(warp.twist, one.twist);
    warp.height = std::max(warp.height, one.height);
  }
  BilinearTessellation result;
  result.curved = warp.height > kFlat;
  if (warp.twist > kFlat) {
    // A cell of n x n leaves the surface by a quarter of the twist over n^2.
    const double affordable =
        std::sqrt(kMostCells / std::max<double>(1, static_cast<double>(indices.size()) / 4));
    const double wanted = std::ceil(std::sqrt(warp.twist / (4 * kTolerance)));
    result.steps = static_cast<int>(std::clamp(std::min(wanted, affordable), 1.0, 64.0));
  }
  const bool with_normals = !corners.normals.empty() || result.curved;
  for (std::size_t i = 0; i < indices.size(); i += 4) {
    append_patch({corners, &indices[i]}, result.steps, with_normals, result.mesh);
  }
  return result;
}

}  // namespace tessera::client::pbrt
