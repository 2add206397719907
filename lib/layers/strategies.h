// Ways to make a path from both of its ends.
#pragma once

namespace tessera::layers {

/// Strategies with `s` vertices from the light and `t` from the eye (the light's and the camera's among
/// them), of paths that are scattered s + t - 2 times.
struct Strategies {
  int s = kAny, t = kAny;
  int least_events = 0;

  static constexpr int kAny = -1;

  bool has(int vertices_from_light, int vertices_from_eye) const {
    return (s == kAny || s == vertices_from_light) && (t == kAny || t == vertices_from_eye) &&
           vertices_from_light + vertices_from_eye - 2 >= least_events;
  }
  bool operator==(const Strategies&) const = default;
};

}  // namespace tessera::layers
