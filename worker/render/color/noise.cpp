#include "render/color/noise.h"

namespace tessera::render::TESSERA_ISA {

namespace {

// Perlin's permutation of 0..255, the same in all implementations.
constexpr std::uint32_t kPermutation[256] = {
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

constexpr float kFiner = 1.99f;          // between octaves: not 2, so that their zeros do not fall together
constexpr float kMeanOfAbsolute = 0.2f;  // of noise

UInt permuted(UInt i) { return gather(kPermutation, bit_cast<std::int32_t>(i & 255u)); }

/// The slope of a corner of the lattice, times the way from there.
Float slope(UInt h, Vec3 d) {
  const Int bits = bit_cast<std::int32_t>(h & 15u);
  const Mask twelve = (bits == 12) | (bits == 13);
  const Float u = select((bits < 8) | twelve, d.x, d.y);
  const Float v = select((bits < 4) | twelve, d.y, d.z);
  const Mask u_down = bit_cast<std::int32_t>(h & 1u) != 0, v_down = bit_cast<std::int32_t>(h & 2u) != 0;
  return select(u_down, -u, u) + select(v_down, -v, v);
}

Float ease(Float t) { return t * t * t * fma(t, fma(t, 6.0f, Float(-15.0f)), Float(10.0f)); }

struct Cell {
  UInt lower;
  Float d;  // from there, in [0, 1)
};

Cell cell_of(Float x) {
  constexpr float kLargest = 4194304.0f;
  x = clamp(select(x == x, x, 0.0f), -kLargest, kLargest);
  const Float lower = floor(x);
  return {bit_cast<std::uint32_t>(to_int(lower)), x - lower};
}

}  // namespace

Float noise(Vec3 p) {
  const Cell x = cell_of(p.x), y = cell_of(p.y), z = cell_of(p.z);
  const Float wx = ease(x.d), wy = ease(y.d), wz = ease(z.d);
  // The four edges along x at each side: [y][z].
  Float edges[2][2];
  UInt hash_x[2] = {permuted(x.lower & 255u), permuted((x.lower & 255u) + 1u)};
  for (int j = 0; j < 2; ++j) {
    for (int k = 0; k < 2; ++k) {
      Float ends[2];
      for (int i = 0; i < 2; ++i) {
        const UInt hash_xy = permuted(hash_x[i] + (y.lower & 255u) + static_cast<std::uint32_t>(j));
        const UInt hash = permuted(hash_xy + (z.lower & 255u) + static_cast<std::uint32_t>(k));
        ends[i] = slope(
            hash, {x.d - static_cast<float>(i), y.d - static_cast<float>(j), z.d - static_cast<float>(k)});
      }
      edges[j][k] = lerp(wx, ends[0], ends[1]);
    }
  }
  return lerp(wz, lerp(wy, edges[0][0], edges[1][0]), lerp(wy, edges[0][1], edges[1][1]));
}

Float fractal_noise(Vec3 p, float roughness, int octaves) {
  Float sum(0.0f);
  float scale = 1, weight = 1;
  for (int i = 0; i < octaves; ++i) {
    sum = fma(Float(weight), noise(p * Float(scale)), sum);
    scale *= kFiner;
    weight *= roughness;
  }
  return sum;
}

Float turbulence(Vec3 p, float roughness, int octaves) {
  Float sum(0.0f);
  float scale = 1, weight = 1;
  for (int i = 0; i < octaves; ++i) {
    sum = fma(Float(weight), abs(noise(p * Float(scale))), sum);
    scale *= kFiner;
    weight *= roughness;
  }
  return sum + weight * kMeanOfAbsolute;
}

}  // namespace tessera::render::TESSERA_ISA
