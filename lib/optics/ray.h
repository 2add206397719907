// Rays and vectors of the optics library: doubles, millimetres.
#pragma once

#include <cmath>

namespace tessera::optics {

struct Vector {
  double x = 0, y = 0, z = 0;
};
inline Vector operator+(Vector a, Vector b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vector operator-(Vector a, Vector b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vector operator*(Vector a, double f) { return {a.x * f, a.y * f, a.z * f}; }
inline double dot(Vector a, Vector b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline double length(Vector a) { return std::sqrt(dot(a, a)); }
inline Vector unit(Vector a) { return a * (1 / length(a)); }

struct Ray {
  Vector origin;
  Vector direction;  // unit length
};

/// Where the ray meets the plane z.
inline Vector at_plane(const Ray& ray, double z) {
  return ray.origin + ray.direction * ((z - ray.origin.z) / ray.direction.z);
}

}  // namespace tessera::optics
