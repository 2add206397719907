#include "render/color/noise.h"

#include "tables/perlin.h"

namespace tessera::render::TESSERA_ISA {

namespace {

constexpr float kFiner = 1.99f;  // between octaves: not 2, so that their zeros do not fall together
constexpr float kMeanAbsoluteNoise = 0.2f;

UInt permuted(UInt i) { return gather(tables::kPerlinPermutation.data(), bit_cast<std::int32_t>(i & 255u)); }

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
  Float d;  // distance from there, in [0, 1)
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
  return sum + weight * kMeanAbsoluteNoise;
}

}  // namespace tessera::render::TESSERA_ISA
