// The ways to make a path from both ends.
#pragma once

namespace tessera::render {

/// Strategies that count: all of them, weighted, or one of `s` vertices from the light and `t` from the eye
/// (the camera's among them), each path with a weight of 1: the picture of all light that it can find.
struct StrategyFilter {
  int s = -1, t = -1;

  bool all() const { return s < 0; }
  bool wants(int vertices_from_light, int vertices_from_eye) const {
    return all() || (vertices_from_light == s && vertices_from_eye == t);
  }
};

}  // namespace tessera::render
