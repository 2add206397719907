// A scene somewhere else, or in another unit of length, by its own numbers.
#pragma once

#include <array>

#include "tessera/v1/scene.pb.h"

namespace tessera::test {

/// p -> scale * p + shift, in doubles.
struct Move {
  double scale = 1;
  std::array<double, 3> shift = {0, 0, 0};
};

/// Moves all that stands in world space: camera, shapes, instances, lights, and what textures look at. Point
/// lights are made stronger so that the picture stays the same.
inline void move_scene(const Move& move, v1::Scene& scene) {
  const auto place = [&](v1::Matrix& matrix) {
    auto& m = *matrix.mutable_elements();
    if (m.empty()) {
      for (int i = 0; i < 16; ++i) m.Add(i % 5 == 0);
    }
    for (int i = 0; i < 12; ++i)
      m[i] = m[i] * move.scale + (i % 4 == 3 ? move.shift[static_cast<std::size_t>(i / 4)] * m[15] : 0);
  };
  const auto place_point = [&](v1::Point3& p) {
    p.set_x(p.x() * move.scale + move.shift[0]);
    p.set_y(p.y() * move.scale + move.shift[1]);
    p.set_z(p.z() * move.scale + move.shift[2]);
  };
  // M becomes M T^-1: points come from where they are now.
  const auto look_back = [&](v1::Matrix& matrix) {
    auto& m = *matrix.mutable_elements();
    if (m.empty()) {
      for (int i = 0; i < 16; ++i) m.Add(i % 5 == 0);
    }
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) {
        m[4 * row + column] /= move.scale;
        m[4 * row + 3] -= m[4 * row + column] * move.shift[static_cast<std::size_t>(column)];
      }
    }
  };
  // Clipping distances are lengths of the world; the lens is in camera space, which is scaled with it.
  v1::Camera& camera = *scene.mutable_camera();
  place(*camera.mutable_world_from_camera());
  camera.set_near_clip(static_cast<float>(camera.near_clip() * move.scale));
  camera.set_far_clip(static_cast<float>(camera.far_clip() * move.scale));
  for (v1::Shape& shape : *scene.mutable_shapes()) {
    place(*shape.mutable_world_from_object());
    if (shape.has_world_from_object_end()) place(*shape.mutable_world_from_object_end());
  }
  for (v1::Instance& instance : *scene.mutable_instances()) {
    place(*instance.mutable_world_from_instance());
    if (instance.has_world_from_instance_end()) place(*instance.mutable_world_from_instance_end());
  }
  const auto brighten = [&](v1::Light& light) {
    light.set_scale(static_cast<float>((light.has_scale() ? light.scale() : 1) * move.scale * move.scale));
  };
  for (v1::Light& light : *scene.mutable_lights()) {
    if (light.has_point()) place_point(*light.mutable_point()->mutable_position()), brighten(light);
    if (light.has_spot()) {
      place_point(*light.mutable_spot()->mutable_position());
      place_point(*light.mutable_spot()->mutable_target());
      brighten(light);
    }
  }
  for (v1::Texture& texture : *scene.mutable_textures()) {
    if (texture.has_noise()) look_back(*texture.mutable_noise()->mutable_texture_from_world());
    if (texture.has_checkerboard() && texture.checkerboard().solid()) {
      look_back(*texture.mutable_checkerboard()->mutable_mapping()->mutable_texture_from_world());
    }
  }
}

}  // namespace tessera::test
