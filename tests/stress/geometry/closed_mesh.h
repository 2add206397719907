// Meshes without a border, for tests that count holes.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "render/shape/shape_table.h"

namespace tessera::render {

struct ClosedMesh {
  std::vector<std::array<double, 3>> vertices;  // about the origin, at distances 0.75 to 1.25
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// An icosahedron, each triangle cut into four `times` times, its points moved along their directions by
/// waves of decreasing length, the first `height` high: seen from the middle, every direction meets it once.
/// Without waves it is convex.
inline ClosedMesh displaced_sphere(int times, double height = 0.13) {
  ClosedMesh mesh;
  const double g = (1 + std::sqrt(5.0)) / 2;
  mesh.vertices = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                   {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  mesh.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                    {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                    {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (int k = 0; k < times; ++k) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [at, fresh] =
          middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(mesh.vertices.size()));
      if (fresh) {
        const auto &p = mesh.vertices[a], &q = mesh.vertices[b];
        mesh.vertices.push_back({p[0] + q[0], p[1] + q[1], p[2] + q[2]});
        auto& m = mesh.vertices.back();
        const double scale = std::sqrt(1 + g * g) / std::sqrt(m[0] * m[0] + m[1] * m[1] + m[2] * m[2]);
        for (double& x : m) x *= scale;
      }
      return at->second;
    };
    std::vector<std::array<std::uint32_t, 3>> finer;
    for (const auto& [a, b, c] : mesh.triangles) {
      const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    mesh.triangles = std::move(finer);
  }
  for (auto& p : mesh.vertices) {
    const double l = std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
    for (double& x : p) x /= l;
    double radius = 1;
    for (int k = 0; k < 4; ++k) {
      const double f = 3 * (1 << k);
      radius += height / (1 << k) * std::sin(f * p[0] + k) * std::sin(f * p[1] + 2 * k) *
                std::sin(f * p[2] + 3 * k);
    }
    for (double& x : p) x *= radius;
  }
  return mesh;
}

/// A unit sphere of slivers from pole to pole, `slices` in all.
inline ClosedMesh sliced_sphere(std::uint32_t slices) {
  constexpr std::uint32_t kStacks = 4;
  ClosedMesh mesh;
  mesh.vertices = {{0, 0, 1}, {0, 0, -1}};
  for (std::uint32_t i = 0; i < slices; ++i) {
    for (std::uint32_t k = 1; k < kStacks; ++k) {
      const double phi = 6.283185307179586 * i / slices, theta = 3.141592653589793 * k / kStacks;
      mesh.vertices.push_back(
          {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)});
    }
    const auto at = [&](std::uint32_t slice, std::uint32_t k) {
      return 2 + slice % slices * (kStacks - 1) + k - 1;
    };
    mesh.triangles.insert(mesh.triangles.end(),
                          {{0, at(i, 1), at(i + 1, 1)}, {1, at(i + 1, kStacks - 1), at(i, kStacks - 1)}});
    for (std::uint32_t k = 1; k + 1 < kStacks; ++k) {
      mesh.triangles.insert(mesh.triangles.end(), {{at(i, k), at(i, k + 1), at(i + 1, k + 1)},
                                                   {at(i, k), at(i + 1, k + 1), at(i + 1, k)}});
    }
  }
  return mesh;
}

/// The mesh in render space, its vertices rounded to floats as build/ does.
inline ShapeTable mesh_table(const ClosedMesh& mesh, std::array<double, 3> centre, double radius) {
  ShapeTable table;
  for (const auto& p : mesh.vertices) {
    Vertex& v = table.vertices.emplace_back();
    for (std::size_t i = 0; i < 3; ++i) v.position[i] = static_cast<float>(centre[i] + radius * p[i]);
  }
  for (const auto& t : mesh.triangles) table.triangles.insert(table.triangles.end(), t.begin(), t.end());
  ShapeRecord shape;
  shape.triangle_count = static_cast<std::int32_t>(mesh.triangles.size());
  shape.vertex_count = static_cast<std::int32_t>(mesh.vertices.size());
  table.shapes = {shape};
  table.world_shape_count = 1;
  return table;
}

}  // namespace tessera::render
