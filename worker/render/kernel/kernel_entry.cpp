// Exports of a kernel module.
#include <algorithm>
#include <memory>

#include "render/accel/accel_entry.h"
#include "render/accel/arithmetic.h"
#include "render/integrator/stage_timer.h"
#include "render/kernel/kernel.h"
#include "render/light/light.h"
#include "render/query/query_entry.h"
#include "render/textbook/ambient_occlusion/ambient_occlusion.h"
#include "render/textbook/irradiance_cache/irradiance_cache.h"
#include "render/textbook/irradiance_cache/phase.h"
#include "render/textbook/preview/preview.h"
#include "render/textbook/radiosity/radiosity.h"
#include "render/textbook/whitted/whitted.h"
#include "render/transport/bdpt/bidirectional.h"
#include "render/transport/bdpt/merging.h"
#include "render/transport/guide/guided_path.h"
#include "render/transport/light/light_tracer.h"
#include "render/transport/mlt/metropolis.h"
#include "render/transport/path/wavefront.h"
#include "render/transport/photon/photon_mapper.h"

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

/// The same, with one event on a path at most.
template <class T, auto... kHow>
std::unique_ptr<Integrator> make_for_one_event(const IntegratorContext& context) {
  const StageTimer timer(context.stats.times, Stage::kCamera);
  return std::make_unique<T>(context, std::min(context.scene.max_depth, 1), kHow...);
}

// Both phases do the same; the second reads what the first has made.
constexpr AlgorithmPhase kCachePhases[] = {{&make_records, &merge_records}, {&make_records, &merge_records}};

constexpr AlgorithmPhase kGuidePhases[] = {
    {&make_guide, &merge_guides}, {&make_guide, &merge_guides}, {&make_guide, &merge_guides}};

std::unique_ptr<Integrator> make_vcm(const IntegratorContext& context) {
  const StageTimer timer(context.stats.times, Stage::kCamera);
  return std::make_unique<Bidirectional>(context, StrategyFilter{}, std::make_unique<Merging>(context.scene));
}

// The list of algorithms.
constexpr Algorithm kAlgorithms[] = {
    {"path", &make<Wavefront>},
    {"volpath", &make<Wavefront>},
    {"light", &make<LightTracer>},
    {"direct", &make_for_one_event<Wavefront>},
    {"whitted", &make<Whitted>},
    {"raycast", &make_for_one_event<Whitted, Whitted::Mirrors::kBlack>},
    {"irradiance-cache", &make<IrradianceCached>, kCachePhases, &prepare_records},
    {"ao", &make<AmbientOcclusion>},
    {"bdpt", &make<Bidirectional>},
    {"vcm", &make_vcm},
    {"radiosity", &make<Radiosity>, radiosity::kPhases, &radiosity::prepare},
    {.name = "preview", .make = &make<Preview>, .prepare = &Preview::prepare},
    {"photon", &make<PhotonMapper>},
    {"mlt", &make<Metropolis>},
    {"guided", &make<GuidedPath>, kGuidePhases, &prepare_guide},
};

std::uint64_t read_clock() { return clock_ticks(); }

}  // namespace

const Kernel& kernel() {
  static const Kernel exported{TESSERA_STRING(TESSERA_ISA),
                               &accel_kernel(),
                               &query_kernel(),
                               kAlgorithms,
                               light_sources(),
                               &read_clock,
                               &arithmetic_checksum};
  return exported;
}

}  // namespace tessera::render::TESSERA_ISA

extern "C" __attribute__((visibility("default"))) const tessera::render::Kernel* tessera_kernel() {
  return &tessera::render::TESSERA_ISA::kernel();
}
