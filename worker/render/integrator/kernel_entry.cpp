// What a kernel module exports.
#include <memory>

#include "render/accel/alpha_filter.h"
#include "render/accel/arithmetic.h"
#include "render/accel/embree_kernel.h"
#include "render/accel/quadric.h"
#include "render/accel/sdf.h"
#include "render/accel/trace.h"
#include "render/integrator/kernel.h"
#include "render/integrator/light/light_tracer.h"
#include "render/integrator/path/wavefront.h"
#include "render/integrator/stage_timer.h"

#define TESSERA_STRING2(x) #x
#define TESSERA_STRING(x) TESSERA_STRING2(x)

namespace tessera::render::TESSERA_ISA {
namespace {

/// Memory for the paths, new for every unit, is part of what starting them costs.
template <class T>
std::unique_ptr<Integrator> make(const IntegratorContext& context) {
  const StageTimer timer(context.stats.times, Stage::kCamera);
  return std::make_unique<T>(context);
}

// The list of algorithms.
constexpr Algorithm kAlgorithms[] = {
    {"path", &make<Wavefront>},
    {"volpath", &make<Wavefront>},
    {"light", &make<LightTracer>},
};

std::uint64_t read_clock() { return clock_ticks(); }

constexpr EmbreeKernel kEmbree{
    {&intersect_quadric, &occluded_quadric, &intersect_sdf, &occluded_sdf, &filter_alpha},
    &make_embree_query};

constexpr Kernel kKernel{TESSERA_STRING(TESSERA_ISA), &kEmbree, kAlgorithms, &read_clock,
                         &arithmetic_checksum};

}  // namespace
}  // namespace tessera::render::TESSERA_ISA

extern "C" __attribute__((visibility("default"))) const tessera::render::Kernel* tessera_kernel() {
  return &tessera::render::TESSERA_ISA::kKernel;
}
