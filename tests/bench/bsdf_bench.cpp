// Cost of the BSDF models: nanoseconds for 16 lanes of eval() and of sample(), with directions that differ by
// lane.
#include <benchmark/benchmark.h>

#include "support/kernel/bsdf_cases.h"

namespace tessera::test {
namespace {

struct Inputs {
  kernel::Vec3 wo, wi;
  kernel::Float u_lobe;
  kernel::Vec2 u;
};

constexpr std::size_t kInputs = 64;

std::vector<Inputs> make_inputs(bool both_sides) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> uniform;
  std::vector<Inputs> inputs(kInputs);
  for (Inputs& input : inputs) {
    Direction wo[kernel::kWidth], wi[kernel::kWidth];
    alignas(64) float u[3][kernel::kWidth];
    for (int i = 0; i < kernel::kWidth; ++i) {
      wo[i] = direction(uniform(random) * 88, uniform(random) * 360);
      wi[i] = direction(uniform(random) * (both_sides ? 180 : 88), uniform(random) * 360);
      for (auto& lanes : u) lanes[i] = uniform(random);
    }
    input = {wide(wo),
             wide(wi),
             kernel::Float::load(u[0]),
             {kernel::Float::load(u[1]), kernel::Float::load(u[2])}};
  }
  return inputs;
}

void eval(benchmark::State& state, const BsdfCase& bsdf) {
  const std::vector<Inputs> inputs = make_inputs(bsdf.kind == render::BsdfKind::kDielectric);
  const kernel::BsdfParams params = bsdf.params();
  const kernel::Bsdf* model = kernel::bsdf_model(bsdf.kind);
  std::size_t i = 0;
  for (auto _ : state) {
    const Inputs& input = inputs[i++ % kInputs];
    kernel::BsdfEval result =
        model->eval(params, input.wo, input.wi, kernel::Transport::kRadiance, kernel::Mask::all());
    benchmark::DoNotOptimize(result);
  }
}

void sample(benchmark::State& state, const BsdfCase& bsdf) {
  const std::vector<Inputs> inputs = make_inputs(false);
  const kernel::BsdfParams params = bsdf.params();
  const kernel::Bsdf* model = kernel::bsdf_model(bsdf.kind);
  std::size_t i = 0;
  for (auto _ : state) {
    const Inputs& input = inputs[i++ % kInputs];
    kernel::BsdfSample result = model->sample(params, input.wo, input.u_lobe, input.u,
                                              kernel::Transport::kRadiance, kernel::Mask::all());
    benchmark::DoNotOptimize(result);
  }
}

/// The cases live as long as the benchmarks that are registered with them.
void register_all() {
  static const BsdfCase cases[] = {
      diffuse({0.8f, 0.8f, 0.8f}),
      diffuse_transmission({0.4f, 0.4f, 0.4f}, {0.3f, 0.3f, 0.3f}),
      conductor(0, 0),
      conductor(0.2f, 0.1f),
      dielectric(0, 0, 1.5f),
      dielectric(0.2f, 0.1f, 1.5f),
      thin_dielectric(1.5f),
      coated_diffuse(0, 0, 1.5f),
      coated_diffuse(0.2f, 0.1f, 1.5f),
      conductor(0.2f, 0.1f, kCopperEta, kCopperK, render::kBeckmann),
      dielectric(0.2f, 0.1f, 1.5f, render::kBeckmann | render::kSeparableMasking),
      plastic(0, 1.5f, 0),
      plastic(0.1f, 1.5f, render::kBeckmann | render::kSeparableMasking),
      principled("plain", {}),
      principled("glass", {.spec_trans = 1}),
      principled("plain", {}, true),
      hair(0.3f, 0.3f, 0.5f)};
  for (const BsdfCase& bsdf : cases) {
    benchmark::RegisterBenchmark(("eval/" + bsdf.name).c_str(),
                                 [&](benchmark::State& state) { eval(state, bsdf); });
    benchmark::RegisterBenchmark(("sample/" + bsdf.name).c_str(),
                                 [&](benchmark::State& state) { sample(state, bsdf); });
  }
}

}  // namespace
}  // namespace tessera::test

int main(int argc, char** argv) {
  tessera::test::register_all();
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
