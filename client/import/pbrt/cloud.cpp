// The procedural cloud of pbrt-v4, and the noise that it is made of.
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "import/pbrt/media.h"

namespace tessera::client::pbrt {
namespace {

// Perlin's permutation of 0..255 [Perlin 1985; the same table in all implementations]. The renderer has it
// too (noise textures); the importers and the renderer share no code.
constexpr std::uint8_t kPermutation[256] = {
    151, 160, 137, 91,  90,  15,  131, 13,  201, 95,  96,  53,  194, 233, 7,   225, 140, 36,  103, 30,
    69,  142, 8,   99,  37,  240, 21,  10,  23,  190, 6,   148, 247, 120, 234, 75,  0,   26,  197, 62,
    94,  252, 219, 203, 117, 35,  11,  32,  57,  177, 33,  88,  237, 149, 56,  87,  174, 20,  125, 136,
    171, 168, 68,  175, 74,  165, 71,  134, 139, 48,  27,  166, 77,  146, 158, 231, 83,  111, 229, 122,
    60,  211, 133, 230, 220, 105, 92,  41,  55,  46,  245, 40,  244, 102, 143, 54,  65,  25,  63,  161,
    1,   216, 80,  73,  209, 76,  132, 187, 208, 89,  18,  169, 200, 196, 135, 130, 116, 188, 159, 86,
    164, 100, 109, 198, 173, 186, 3,   64,  52,  217, 226, 250, 124, 123, 5,   202, 38,  147, 118, 126,
    255, 82,  85,  212, 207, 206, 59,  227, 47,  16,  58,  17,  182, 189, 28,  42,  223, 183, 170, 213,
    119, 248, 152, 2,   44,  154, 163, 70,  221, 153, 101, 155, 167, 43,  172, 9,   129, 22,  39,  253,
    19,  98,  108, 110, 79,  113, 224, 232, 178, 185, 112, 104, 218, 246, 97,  228, 251, 34,  242, 193,
    238, 210, 144, 12,  191, 179, 162, 241, 81,  51,  145, 235, 249, 14,  239, 107, 49,  192, 214, 31,
    181, 199, 106, 157, 184, 84,  204, 176, 115, 121, 50,  45,  127, 4,   150, 254, 138, 236, 205, 93,
    222, 114, 67,  29,  24,  72,  243, 141, 128, 195, 78,  66,  215, 61,  156, 180};

double gradient(std::int64_t x, std::int64_t y, std::int64_t z, double dx, double dy, double dz) {
  const auto permuted = [](std::int64_t i) { return std::int64_t{kPermutation[i & 255]}; };
  const std::int64_t h = permuted(permuted(permuted(x) + y) + z) & 15;
  const double u = h < 8 || h == 12 || h == 13 ? dx : dy;
  const double v = h < 4 || h == 12 || h == 13 ? dy : dz;
  return (h & 1 ? -u : u) + (h & 2 ? -v : v);
}

double noise(const Vector3& p) {
  std::int64_t i[3];
  double d[3], w[3];
  for (std::size_t a = 0; a < 3; ++a) {
    const double cell = std::floor(std::fmod(p[a], 1073741824.0));
    i[a] = static_cast<std::int64_t>(cell);
    d[a] = std::fmod(p[a], 1073741824.0) - cell;
    w[a] = d[a] * d[a] * d[a] * (d[a] * (6 * d[a] - 15) + 10);
  }
  const auto corner = [&](int x, int y, int z) {
    return gradient(i[0] + x, i[1] + y, i[2] + z, d[0] - x, d[1] - y, d[2] - z);
  };
  const auto along_x = [&](int y, int z) { return std::lerp(corner(0, y, z), corner(1, y, z), w[0]); };
  const auto along_y = [&](int z) { return std::lerp(along_x(0, z), along_x(1, z), w[1]); };
  return std::lerp(along_y(0), along_y(1), w[2]);
}

Vector3 scaled(const Vector3& p, double s) { return {s * p[0], s * p[1], s * p[2]}; }

}  // namespace

double CloudShape::at(const Vector3& p) const {
  Vector3 q = scaled(p, frequency);
  if (wispiness > 0) {
    // The point is moved along the noise's slope, twice.
    constexpr double kStep = 0.01;
    double weight = 0.05 * wispiness, finer = 10;
    for (int octave = 0; octave < 2; ++octave) {
      const Vector3 at = scaled(q, finer);
      const double here = noise(at);
      Vector3 slope;
      for (std::size_t a = 0; a < 3; ++a) {
        Vector3 beside = at;
        beside[a] += kStep;
        slope[a] = (noise(beside) - here) / kStep;
      }
      for (std::size_t a = 0; a < 3; ++a) q[a] += weight * slope[a];
      weight *= 0.5;
      finer *= 1.99;
    }
  }
  double sum = 0, weight = 0.5, finer = 1;
  for (int octave = 0; octave < 5; ++octave) {
    sum += weight * noise(scaled(q, finer));
    weight *= 0.5;
    finer *= 1.99;
  }
  // Thinner with height.
  const double d = std::clamp((1 - p[1]) * 4.5 * density * sum, 0.0, 1.0);
  return std::clamp(d + 2 * std::max(0.0, 0.5 - p[1]), 0.0, 1.0);
}

}  // namespace tessera::client::pbrt
