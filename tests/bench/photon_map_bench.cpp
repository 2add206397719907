// Cost of a map of photons: building it, and radiance estimates from it. Photons lie on the sides of a box,
// places of queries too, in the order in which a picture's pixels see them.
#include <benchmark/benchmark.h>

#include <random>
#include <vector>

#include "render/transport/photon_map/photon.h"
#include "render/transport/photon_map/photon_map.h"

namespace tessera::render::TESSERA_ISA {
namespace {

using Map = PhotonMap<PhotonFields>;

/// A million photons on the six sides of a unit cube.
constexpr int kPhotons = 1 << 20;

Vec3 on_a_side(int side, Float a, Float b) {
  const Float at(side % 2 == 0 ? 0.0f : 1.0f);
  if (side / 2 == 0) return {at, a, b};
  return side / 2 == 1 ? Vec3{a, at, b} : Vec3{a, b, at};
}

void fill(Map& map) {
  map.clear();
  std::mt19937 random(1);
  std::uniform_real_distribution<float> uniform;
  for (int i = 0; i < kPhotons; i += kWidth) {
    alignas(64) float a[kWidth], b[kWidth];
    for (int k = 0; k < kWidth; ++k) a[k] = uniform(random), b[k] = uniform(random);
    const Vec3 up{Float(0.0f), Float(0.0f), Float(1.0f)};
    map.append({.position = on_a_side(i / kWidth % 6, Float::load(a), Float::load(b)),
                .direction = up,
                .way = Float(1.0f),
                .flux = Spectrum(1.0f),
                .steps = Int(1),
                .alone = Int(0)},
               Mask::all());
  }
}

/// The radius of a disk on a side that `photons` lie on.
float radius_for(double photons) {
  return static_cast<float>(std::sqrt(photons * 6 / kPhotons / 3.14159265));
}

void build(benchmark::State& state) {
  Map map;
  for (auto _ : state) {
    state.PauseTiming();
    fill(map);
    state.ResumeTiming();
    map.build(radius_for(20));
  }
  state.SetItemsProcessed(state.iterations() * kPhotons);
}

/// Places in rows on the sides, in blocks of 16.
std::vector<Vec3> places() {
  std::vector<Vec3> result;
  constexpr int kSide = 256;
  for (int row = 0; row < kSide; ++row) {
    for (int column = 0; column < kSide; column += kWidth) {
      const Float x = (to_float(Int::iota(column)) + 0.5f) * (1.0f / kSide);
      result.push_back(on_a_side(row % 6, x, Float((static_cast<float>(row) + 0.5f) / kSide)));
    }
  }
  return result;
}

/// Sums of flux, a place at a time, as diffuse surfaces need them.
void look_up(benchmark::State& state) {
  Map map;
  fill(map);
  map.build(radius_for(static_cast<double>(state.range(0))));
  const std::vector<Vec3> at = places();
  std::size_t i = 0;
  for (auto _ : state) {
    alignas(64) float x[kWidth], y[kWidth], z[kWidth];
    at[i % at.size()].x.store(x), at[i % at.size()].y.store(y), at[i % at.size()].z.store(z);
    ++i;
    for (int k = 0; k < kWidth; ++k) {
      Spectrum sum(0.0f);
      map.for_each_near(x[k], y[k], z[k], [&](std::int32_t first, Mask near, Float) {
        sum += select_or_zero(near, map.load(first).flux);
      });
      benchmark::DoNotOptimize(sum);
    }
  }
  state.SetItemsProcessed(state.iterations() * kWidth);
}

/// The same, 16 places at a time, as other surfaces need them.
void look_up_pairs(benchmark::State& state) {
  Map map;
  fill(map);
  map.build(radius_for(static_cast<double>(state.range(0))));
  const std::vector<Vec3> at = places();
  std::size_t i = 0;
  for (auto _ : state) {
    Spectrum sum(0.0f);
    map.for_each_near(at[i++ % at.size()], Mask::all(), [&](const Map::Wide& photons, Mask near) {
      sum += select_or_zero(near, photons.flux);
    });
    benchmark::DoNotOptimize(sum);
  }
  state.SetItemsProcessed(state.iterations() * kWidth);
}

BENCHMARK(build)->Unit(benchmark::kMillisecond);
BENCHMARK(look_up)->Arg(4)->Arg(10)->Arg(20)->Arg(100);
BENCHMARK(look_up_pairs)->Arg(4)->Arg(10)->Arg(20)->Arg(100);

}  // namespace
}  // namespace tessera::render::TESSERA_ISA

BENCHMARK_MAIN();
